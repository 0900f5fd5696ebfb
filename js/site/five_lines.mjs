// The page that embeds the player, as short as it can be. A formatter would make more lines of it.

export const FIVE_LINES = `<!doctype html>
<html lang="en">
<title>My clip</title>
<script type="module" src="player.js"></script>
<fvv-player src="clips/players.fvv" controls autoplay loop></fvv-player>
`;
