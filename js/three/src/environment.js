// The static environment of a stream as meshes of three. Its pictures include the light, so that lamps of the page do not light it;
// shadows of the page's lamps fall on it.

import {
  BufferAttribute,
  BufferGeometry,
  ClampToEdgeWrapping,
  DoubleSide,
  FrontSide,
  Group,
  LinearMipmapLinearFilter,
  Mesh,
  MeshBasicMaterial,
  RepeatWrapping,
  ShadowMaterial,
  SRGBColorSpace,
  Texture,
} from "three";

/** How dark shadows are: the light that stays is what the player's shadows leave of a single lamp. */
const SHADOW = 0.6;
const SHARPNESS = 8; // of textures that are seen from the side

function textureOf(image, isClamped) {
  const texture = new Texture(image);
  texture.flipY = false;
  texture.colorSpace = SRGBColorSpace;
  texture.wrapS = texture.wrapT = isClamped ? ClampToEdgeWrapping : RepeatWrapping;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.anisotropy = SHARPNESS;
  texture.needsUpdate = true;
  return texture;
}

function geometryOf({ localPositions, positions, uvs, faces }) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(localPositions ?? positions, 3));
  if (uvs) geometry.setAttribute("uv", new BufferAttribute(uvs, 2));
  geometry.setIndex(new BufferAttribute(faces, 1));
  geometry.computeVertexNormals();
  return geometry;
}

export class EnvironmentGroup extends Group {
  #owned = []; // what is disposed of
  #turn = 0;

  /** environments: of a decoder. */
  async show(environments) {
    const turn = ++this.#turn;
    const images = await Promise.all(
      environments.map(({ pictures }) =>
        Promise.all(
          pictures.map(({ data, type }) =>
            createImageBitmap(new Blob([data], { type }), { colorSpaceConversion: "none", premultiplyAlpha: "none" }),
          ),
        ),
      ),
    );
    if (turn !== this.#turn) return;
    this.#empty();
    environments.forEach(({ parts }, i) => {
      for (const part of parts) if (part.faceCount) this.#add(part, images[i]);
    });
  }

  #add(part, images) {
    const geometry = geometryOf(part);
    const side = part.doubleSided ? DoubleSide : FrontSide;
    const map = part.picture === null ? null : textureOf(images[part.picture], part.clamped);
    const material = new MeshBasicMaterial({ side, map, toneMapped: false });
    material.color.setRGB(...part.colour);
    const mesh = new Mesh(geometry, material);
    // Equal depths: the shadow is drawn over its surface.
    const shade = new Mesh(geometry, new ShadowMaterial({ side, opacity: SHADOW, polygonOffset: true }));
    shade.material.polygonOffsetFactor = shade.material.polygonOffsetUnits = -1;
    shade.receiveShadow = true;
    shade.raycast = () => {};
    for (const one of [mesh, shade]) one.position.fromArray(part.origin ?? [0, 0, 0]);
    this.add(mesh, shade);
    this.#owned.push(geometry, material, shade.material, ...(map ? [map] : []));
  }

  #empty() {
    this.clear();
    for (const one of this.#owned.splice(0)) one.dispose();
  }
  dispose() {
    this.#turn++;
    this.#empty();
  }
}
