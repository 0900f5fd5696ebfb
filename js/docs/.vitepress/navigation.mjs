// The menu above all pages, and the one beside them.

const page = (text, link) => ({ text, link });

export const navigation = [
  page("Guide", "/guide/your-own-capture"),
  page("Format", "/spec/fvv"),
  {
    text: "Reference",
    items: [
      page("Command line", "/cli/"),
      page("C: libfvv", "/c/"),
      page("C++: fvv_mux and others", "/cpp/"),
      page("Python", "/python/api"),
      page("JavaScript", "/js/api/"),
    ],
  },
  page("Benchmarks", "/evidence/benchmarks"),
  // The demo site, in which the documentation is the folder docs.
  { text: "Player", link: "/../", target: "_self" },
];

const guide = [
  page("Overview", "/overview"),
  page("Your own capture in ten minutes", "/guide/your-own-capture"),
  page("The command line", "/guide/command-line"),
  page("Read in Python", "/guide/python"),
  page("Libraries", "/guide/libraries"),
  page("An encoder in C", "/guide/encoder-in-c"),
  page("In a three.js scene", "/guide/three"),
  page("Live", "/guide/live"),
  page("Write a decoder", "/guide/write-a-decoder"),
  page("Concepts", "/guide/concepts"),
  page("Browsers", "/guide/browsers"),
  page("Questions", "/guide/questions"),
  page("Comparison", "/guide/comparison"),
  page("Glossary", "/guide/glossary"),
];

const encoding = [
  page("Error budget", "/encoding/budget"),
  page("Tracking", "/encoding/tracking"),
  page("Tiles", "/encoding/tiles"),
  page("Visibility", "/encoding/visibility"),
  page("Colours of vertices", "/encoding/colours"),
  page("Unlike cameras", "/encoding/match"),
  page("Texture inset", "/encoding/inset"),
  page("Ladder of quality", "/encoding/ladder"),
  page("Sound", "/encoding/sound"),
  page("Incomplete frames", "/encoding/frames"),
  page("Many machines", "/encoding/parts"),
  page("Speed", "/encoding/speed"),
  page("High dynamic range", "/encoding/hdr"),
];

const tools = [
  page("fvvmux without capture.json", "/tools/fvvmux-inputs"),
  page("fvvcapture", "/tools/fvvcapture"),
  page("Keying", "/tools/fvvcapture-keying"),
  page("Visual hulls", "/tools/fvvcapture-hull"),
  page("Calibrating cameras", "/tools/fvvcapture-calibrate"),
  page("Calibrations of other programs", "/tools/calibration"),
  page("capture.json", "/spec/capture"),
  page("fvvcompare", "/tools/fvvcompare"),
  page("fvvdemux", "/tools/fvvdemux"),
  page("fvvrecover", "/tools/fvvrecover"),
  page("fvvrender", "/tools/fvvrender"),
  page("fvvserve", "/tools/fvvserve"),
  page("fvvsynth", "/tools/fvvsynth"),
  page("Outputs and exit codes", "/tools/outputs"),
];

const format = [
  page("Specification", "/spec/fvv"),
  page("Registry", "/spec/registry"),
  page("Issues", "/spec/issues"),
  page("Reasons", "/format/reasons"),
  page("Draco's bitstream", "/format/draco"),
  page("Files of spec/", "/spec/"),
];

const proof = [
  page("Benchmarks", "/evidence/benchmarks"),
  page("Charts", "/evidence/charts"),
  page("Conformance", "/evidence/conformance"),
  page("Conformance protocol", "/conformance/protocol"),
  page("Test vectors", "/conformance/vectors"),
  page("Fuzzing", "/evidence/fuzzing"),
  page("Other machines", "/evidence/matrix"),
  page("Networks", "/evidence/networks"),
  page("Pictures of the player", "/evidence/player-pictures"),
  page("Security", "/security"),
];

const packages = [
  page("@fvv/player", "/js/player"),
  page("@fvv/decoder", "/js/decoder"),
  page("@fvv/three", "/js/three"),
  page("@fvv/video-fallback", "/js/video-fallback"),
  page("fvv for Python", "/python/"),
];

/** references: [{title, folder, pages: [{text, link}]}], made from sources; each has a menu of its own. */
export function sidebar(references) {
  // Groups are always open: what collapses in this theme is a button with buttons inside, which screen readers cannot use.
  const group = (text, items) => ({ text, items });
  const first = ({ title, pages }) => page(title, pages[0].link);
  const main = [
    group("Guide", guide),
    group("Packages", packages),
    group("Reference", references.map(first)),
    group("Tools", tools),
    group("Encoding", encoding),
    group("Format", format),
    group("Evidence", proof),
    group("Project", [
      page("Where things are", "/project/repository"),
      page("Packages", "/packaging"),
      page("Releases", "/project/release"),
      page("Compatibility", "/project/compatibility"),
      page("Binary interface", "/project/abi"),
      page("Governance", "/project/governance"),
      page("Licences and patents", "/project/patents"),
      page("Contributing", "/contributing"),
      page("Changes", "/changelog"),
    ]),
  ];
  const own = references
    .filter(({ pages }) => pages.length > 1)
    .map(({ title, folder, pages }) => [
      `/${folder}/`,
      [group(title, pages), group("Other references", references.map(first))],
    ]);
  return { ...Object.fromEntries(own), "/": main };
}
