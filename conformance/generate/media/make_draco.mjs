// Writes draco.json: bitstreams of integer attributes by the npm package draco3d, as clause 8.4 of spec/fvv.md has them.
// usage: node make_draco.mjs SHAPES.json > draco.json, where make.py writes SHAPES.json; needs js/node_modules.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(new URL("../../../js/package.json", import.meta.url));
const draco = await require("draco3d").createEncoderModule({});

function encoded(shape) {
  const encoder = new draco.Encoder();
  const builder = new draco.MeshBuilder();
  const mesh = new draco.Mesh();
  const vertices = shape.positions.length / 3;
  builder.AddFacesToMesh(mesh, shape.faces.length / 3, new Uint32Array(shape.faces));
  const add = (type, values, components) => {
    if (values) builder.AddInt32Attribute(mesh, type, vertices, components, new Int32Array(values));
  };
  add(draco.POSITION, shape.positions, 3);
  add(draco.TEX_COORD, shape.texture, 2);
  add(draco.NORMAL, shape.normals, 2);
  if (shape.floats) builder.AddFloatAttributeToMesh(mesh, draco.GENERIC, vertices, 1, new Float32Array(vertices));
  encoder.SetSpeedOptions(shape.speed, shape.speed);
  encoder.SetEncodingMethod(shape.sequential ? draco.MESH_SEQUENTIAL_ENCODING : draco.MESH_EDGEBREAKER_ENCODING);
  const out = new draco.DracoInt8Array();
  const size = encoder.EncodeMeshToDracoBuffer(mesh, out);
  if (!size) throw new Error(`${shape.name}: not encoded`);
  const bytes = Buffer.alloc(size);
  for (let i = 0; i < size; i++) bytes[i] = out.GetValue(i) & 255;
  return bytes;
}

const shapes = JSON.parse(readFileSync(process.argv[2]));
const out = {};
for (const shape of shapes) {
  const decoder = await require("draco3d").createDecoderModule({});
  const data = encoded(shape);
  const buffer = new decoder.DecoderBuffer();
  buffer.Init(new Int8Array(data), data.length);
  const mesh = new decoder.Mesh();
  const reader = new decoder.Decoder();
  const status = reader.DecodeBufferToMesh(buffer, mesh);
  if (!status.ok()) throw new Error(`${shape.name}: ${status.error_msg()}`);
  out[shape.name] = { vertices: mesh.num_points(), faces: mesh.num_faces(), data: data.toString("base64") };
  if (!shape.decoded) continue;
  // In the order of the bitstream, for meshes that follow.
  const positions = new decoder.DracoInt32Array();
  reader.GetAttributeInt32ForAllPoints(mesh, reader.GetAttribute(mesh, 0), positions);
  const face = new decoder.DracoInt32Array();
  const list = (array, size) => Array.from({ length: size }, (_, i) => array.GetValue(i));
  out[shape.name].decoded = {
    positions: list(positions, 3 * mesh.num_points()),
    faces: Array.from({ length: mesh.num_faces() }, (_, i) => {
      reader.GetFaceFromMesh(mesh, i, face);
      return list(face, 3);
    }).flat(),
  };
}
process.stdout.write(`${JSON.stringify({ made_with: "draco3d 1.5.9", meshes: out }, null, 1)}\n`);
