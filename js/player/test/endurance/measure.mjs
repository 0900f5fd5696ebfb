// Plays the numbered board for long and prints what was found as JSON: node measure.mjs [FRAMES [SEEKS]], 10000 and 100.

import { Session, endure } from "./session.mjs";

const [frames = 10000, actions = 100] = process.argv.slice(2).map(Number);
const session = await Session.open();
try {
  session.makeStream("board", { frames: 500, group: 25 });
  await session.play("board");
  const found = await endure(session, { frames, actions });
  if (session.browser.troubles.length) throw new Error(session.browser.troubles.join("\n"));
  console.log(JSON.stringify(found, null, 1));
} finally {
  await session.close();
}
