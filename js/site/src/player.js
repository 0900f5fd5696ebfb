// What a page includes that embeds the player, and nothing else.

import "@fvv/player";
