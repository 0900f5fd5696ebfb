// Plays the numbered board for a long time and prints the results as JSON.
// usage: node measure.mjs [FRAMES [SEEKS [BROWSER]]], default 10000 100 chromium

import { Session, endure } from "./session.mjs";

const [frames = 10000, actions = 100, browser = "chromium"] = process.argv.slice(2);
const session = await Session.open(browser);
try {
  session.makeStream("board", { frames: 500, group: 25 });
  await session.play("board");
  const found = await endure(session, { frames: Number(frames), actions: Number(actions) });
  if (session.browser.troubles.length) throw new Error(session.browser.troubles.join("\n"));
  console.log(JSON.stringify(found, null, 1));
} finally {
  await session.close();
}
