// The pages of the site: what all have around their content, and the page that embeds the player.

/** The documentation of js/docs is in the site's folder docs. */
const PAGES = [
  ["", "Player"],
  ["embed.html", "Embed"],
  ["three/", "three.js"],
  ["docs/spec/fvv.html", "Specification"],
  ["docs/", "Docs"],
];

/** A whole page. page: address below the site's root, "" for the first; script: a module; content: HTML of main. */
export function frame({ title, page, script, content }) {
  const root = "../".repeat(page.split("/").length - 1) || "./";
  const links = PAGES.map(([address, name]) => {
    const current = address === page ? ' aria-current="page"' : "";
    return `        <a href="${root}${address}"${current}>${name}</a>`;
  });
  return `<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8" />
    <meta name="viewport" content="width=device-width, initial-scale=1, viewport-fit=cover" />
    <meta name="color-scheme" content="light dark" />
    <title>${title}</title>
    <link rel="icon" href="${root}favicon.ico" />
    <link rel="stylesheet" href="${root}site.css" />
    <script type="module" src="${root}${script}"></script>
  </head>
  <body>
    <a class="skip" href="#content">Skip to content</a>
    <header class="top">
      <a class="brand" href="${root}">fvv</a>
      <nav aria-label="Pages">
${links.join("\n")}
      </nav>
      <button class="theme" type="button" data-theme-toggle aria-label="Dark or light">
        <svg viewBox="0 0 24 24" aria-hidden="true">
          <circle cx="12" cy="12" r="8.5" fill="none" stroke="currentColor" stroke-width="2" />
          <path d="M12 3.5a8.5 8.5 0 0 1 0 17z" fill="currentColor" />
        </svg>
      </button>
    </header>
    <main id="content">
${content.trimEnd()}
    </main>
    <footer class="end">
      <p>
        fvv, a streaming file format for free-viewpoint video, under the Apache License 2.0.
        <a href="${root}embed.html">Five lines of HTML</a> put the player into a page; <a href="${root}docs/spec/fvv.html">the specification</a>
        describes the format.
      </p>
    </footer>
  </body>
</html>
`;
}

/** The page that embeds the player, as short as possible; a formatter would make more lines of it. */
export const FIVE_LINES = `<!doctype html>
<html lang="en">
<meta name="viewport" content="width=device-width" /><title>My clip</title>
<script type="module" src="player.js"></script>
<main><fvv-player src="clips/players.fvv" controls autoplay loop></fvv-player><h1>My clip</h1></main>
`;
