// Links between files of the repository: what is found, and what is dead.

import assert from "node:assert/strict";
import { test } from "node:test";

import { anchorsOf, deadBecause, mapLinks, withoutCode } from "../links.mjs";

test("links in prose are found, those in code are not", () => {
  const found = [];
  const text = 'See [`a`](b.md#c) and ![d](e.png), `[f](g.md)`, <img src="h.jpg">\n```md\n[i](j.md)\n```\n[k](l.md)\n';
  const mapped = mapLinks(text, (address, isPicture) => {
    found.push([address, isPicture]);
    return address.toUpperCase();
  });
  assert.deepEqual(found, [
    ["b.md#c", false],
    ["e.png", true],
    ["h.jpg", true],
    ["l.md", false],
  ]);
  assert.match(mapped, /\(B\.MD#C\).*\(E\.PNG\).*`\[f\]\(g\.md\)`.*"H\.JPG"/);
  assert.match(mapped, /\(j\.md\)\n```\n\[k\]\(L\.MD\)/);
  assert.equal(withoutCode(text).length, text.length);
});

test("anchors are those of GitHub", () => {
  const text = "# A b\n## `c_d`: e-f (g)\n## A b\n```\n# no heading\n```\n### [8.10 Lost](x.md) frames\n";
  assert.deepEqual([...anchorsOf(text)], ["a-b", "c_d-e-f-g", "a-b-1", "810-lost-frames"]);
});

test("a link to a file, a folder or a heading that is not there is dead", () => {
  const dead = (address) => deadBecause("docs/guide/glossary.md", address);
  for (const address of [
    "../../spec/fvv.md#81-lattice",
    "../../LICENSE",
    "diagrams",
    "#streams",
    "https://example.org/x.md#y",
  ])
    assert.equal(dead(address), null, address);
  assert.match(dead("../../spec/fvw.md"), /docs\/guide\/glossary\.md: .*there is no spec\/fvw\.md/);
  assert.match(dead("../../spec/fvv.md#81-lettuce"), /spec\/fvv\.md has no heading/);
  assert.match(dead("#stream"), /no heading/);
  assert.match(dead("../../../elsewhere"), /outside/);
});
