// The script of pages that embed the player.

import "@fvv/player";
