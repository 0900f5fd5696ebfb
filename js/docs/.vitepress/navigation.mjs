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
  page("Benchmarks", "/benchmarks"),
  // The demo site, in which the documentation is the folder docs.
  { text: "Player", link: "/../", target: "_self" },
];

const guide = [
  page("Your own capture in ten minutes", "/guide/your-own-capture"),
  page("Overview", "/overview"),
  page("Concepts", "/concepts"),
  page("Browsers", "/browsers"),
  page("Questions", "/questions"),
  page("Comparison", "/comparison"),
  page("Glossary", "/glossary"),
];

const encoding = [
  page("Error budget", "/fvvmux-budget"),
  page("Tiles", "/fvvmux-tiles"),
  page("Visibility", "/fvvmux-visibility"),
  page("Colours of vertices", "/fvvmux-colours"),
  page("Unlike cameras", "/fvvmux-match"),
  page("Texture inset", "/fvvmux-inset"),
  page("Ladder of quality", "/fvvmux-ladder"),
  page("Sound", "/fvvmux-sound"),
  page("Incomplete frames", "/fvvmux-frames"),
  page("Many machines", "/fvvmux-parts"),
  page("Speed", "/fvvmux-speed"),
  page("High dynamic range", "/hdr"),
];

const tools = [
  page("fvvmux without capture.json", "/fvvmux-inputs"),
  page("fvvcapture", "/fvvcapture"),
  page("Keying", "/fvvcapture-keying"),
  page("Visual hulls", "/fvvcapture-hull"),
  page("Calibrating cameras", "/fvvcapture-calibrate"),
  page("Calibrations of other programs", "/calibration"),
  page("capture.json", "/spec/capture"),
  page("fvvcompare", "/fvvcompare"),
  page("fvvdemux", "/fvvdemux"),
  page("fvvrecover", "/fvvrecover"),
  page("fvvrender", "/fvvrender"),
  page("fvvserve", "/fvvserve"),
  page("fvvsynth", "/fvvsynth"),
  page("Outputs and exit codes", "/outputs"),
];

const format = [
  page("Specification", "/spec/fvv"),
  page("Registry", "/spec/registry"),
  page("Issues", "/spec/issues"),
  page("Reasons", "/format-reasons"),
  page("Draco's bitstream", "/draco"),
  page("Files of spec/", "/spec/"),
];

const proof = [
  page("Benchmarks", "/benchmarks"),
  page("Charts", "/charts"),
  page("Conformance", "/conformance"),
  page("Conformance protocol", "/conformance/protocol"),
  page("Test vectors", "/conformance/vectors"),
  page("Fuzzing", "/fuzzing"),
  page("Other machines", "/matrix"),
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
      page("Packages", "/packaging"),
      page("Releases", "/release"),
      page("Binary interface", "/abi"),
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
