meta:
  id: fvv
  title: fvv, a streaming format for free-viewpoint video
  file-extension: fvv
  license: Apache-2.0
  ks-version: "0.10"
  encoding: UTF-8
  endian: le
doc: |
  The container and the fixed part of every payload of format 0.2, as spec/fvv.md describes them. Payloads that are entropy-coded
  (Draco, meshoptimizer, range coder, pictures, sound) are bytes here. CRCs are fields that are not checked.
doc-ref: spec/fvv.md
seq:
  - id: header
    type: file_header
  - id: chunks
    type: chunk
    repeat: eos
types:
  file_header:
    doc-ref: clause 3.1
    seq:
      - id: signature
        contents: [0x89, FVV, 0x0d, 0x0a, 0x1a, 0x0a]
      - id: written_major
        type: u2
      - id: written_minor
        type: u2
      - id: reader_major
        type: u2
      - id: reader_minor
        type: u2
      - id: reserved
        type: u4
        valid: 0
      - id: crc
        type: u4
  chunk:
    doc-ref: clauses 4.1 to 4.3
    seq:
      - id: type
        type: str
        size: 4
        encoding: ASCII
      - id: flags
        type: chunk_flags
        size: 1
      - id: counter
        type: u1
      - id: track
        type: u2
      - id: time
        type: s8
      - id: payload_size
        type: u8
      - id: payload_crc
        type: u4
      - id: header_crc
        type: u4
      - id: payload
        size: payload_size
        type:
          switch-on: type
          cases:
            '"SCEN"': scene
            '"TRAK"': track
            '"META"': metadata
            '"CAMR"': camera
            '"VCFG"': video
            '"TILE"': tile_layout
            '"ACFG"': audio
            '"DCFG"': data
            '"TEXR"': texturing
            '"GRUP"': group
            '"MESH"': mesh
            '"CALB"': calibration
            '"VISI"': visibility
            '"COLR"': colours
            '"BACK"': environment
            '"AUDI"': packets
            '"GEND"': group_end
            '"INDX"': index
            '"FOOT"': footer
      - id: padding
        type: u1
        valid: 0
        repeat: expr
        repeat-expr: (8 - payload_size % 8) % 8
  chunk_flags:
    doc-ref: clause 4.2
    meta:
      bit-endian: le
    seq:
      - id: critical
        type: b1
      - id: key
        type: b1
      - id: last
        type: b1
      - id: reserved
        type: b5
        valid: 0
  uleb128:
    doc-ref: clause 2.3
    seq:
      - id: bytes
        type: u1
        repeat: until
        repeat-until: _ < 128
    instances:
      value:
        doc: The first five bytes; a number of 35 bits or more needs the bytes.
        value: >-
          (bytes[0] & 127)
          + (bytes.size > 1 ? (bytes[1] & 127) * 128 : 0)
          + (bytes.size > 2 ? (bytes[2] & 127) * 16384 : 0)
          + (bytes.size > 3 ? (bytes[3] & 127) * 2097152 : 0)
          + (bytes.size > 4 ? (bytes[4] & 127) * 268435456 : 0)
  vector:
    seq:
      - id: x
        type: f8
      - id: y
        type: f8
      - id: z
        type: f8
  scene:
    doc-ref: clause 5.1
    seq:
      - id: time_base_numerator
        type: u4
      - id: time_base_denominator
        type: u4
      - id: frame_duration
        type: s8
      - id: lattice_origin
        type: vector
      - id: lattice_step
        type: f8
      - id: up_axis
        type: u1
        enum: up_axis
      - id: flags
        type: u1
        valid:
          max: 1
      - id: reserved
        type: u1
        valid: 0
        repeat: expr
        repeat-expr: 6
  track:
    doc-ref: clause 5.2
    seq:
      - id: kind
        type: u1
        enum: track_kind
      - id: flags
        type: u1
        valid:
          max: 1
      - id: name_size
        type: u2
      - id: time_base_numerator
        type: u4
      - id: time_base_denominator
        type: u4
      - id: alternate_group
        type: u2
      - id: rank
        type: u2
      - id: bit_rate
        type: u4
      - id: nominal_size
        type: u4
      - id: name
        type: str
        size: name_size
  metadata:
    doc-ref: clause 5.3
    seq:
      - id: json
        type: str
        size-eos: true
  camera:
    doc-ref: clause 9.2
    seq:
      - id: id
        type: u2
        valid:
          max: 65534
      - id: lens
        type: u1
        enum: lens
      - id: flags
        type: u1
        valid:
          max: 1
      - id: name_size
        type: u4
      - id: width
        type: u4
      - id: height
        type: u4
      - id: fx
        type: f8
      - id: fy
        type: f8
      - id: cx
        type: f8
      - id: cy
        type: f8
      - id: skew
        type: f8
      - id: distortion
        type: f8
        repeat: expr
        repeat-expr: 8
      - id: r_max
        type: f8
      - id: rotation
        type: f8
        repeat: expr
        repeat-expr: 9
      - id: translation
        type: vector
      - id: name
        type: str
        size: name_size
  video:
    doc-ref: clause 10.1
    seq:
      - id: codec
        type: str
        size: 4
        encoding: ASCII
      - id: width
        type: u4
      - id: height
        type: u4
      - id: shows
        type: u1
        enum: shows
      - id: bit_depth
        type: u1
      - id: colour_primaries
        type: u1
      - id: transfer_characteristics
        type: u1
      - id: matrix_coefficients
        type: u1
      - id: full_range
        type: u1
        valid:
          max: 1
      - id: codec_string_size
        type: u2
      - id: record_size
        type: u4
      - id: record
        size: record_size
      - id: codec_string
        type: str
        size: codec_string_size
  rectangle:
    seq:
      - id: x
        type: u2
      - id: y
        type: u2
      - id: width
        type: u2
        valid:
          min: 1
      - id: height
        type: u2
        valid:
          min: 1
  tile_layout:
    doc-ref: clause 10.2
    seq:
      - id: count
        type: u4
        valid:
          min: 1
      - id: reserved
        type: u4
        valid: 0
      - id: tiles
        type: tile
        repeat: expr
        repeat-expr: count
  tile:
    seq:
      - id: camera
        type: u2
      - id: flags
        type: u2
        valid: 0
      - id: source
        type: rectangle
      - id: destination
        type: rectangle
      - id: reserved
        type: u4
        valid: 0
  audio:
    doc-ref: clause 20.1
    seq:
      - id: codec
        type: str
        size: 4
        encoding: ASCII
      - id: channels
        type: u1
      - id: flags
        type: u1
        valid:
          max: 3
      - id: language_size
        type: u2
      - id: record_size
        type: u4
      - id: packet_duration
        type: u4
      - id: preroll
        type: u4
      - id: reserved
        type: u4
        valid: 0
      - id: position
        type: vector
      - id: record
        size: record_size
      - id: language
        type: str
        size: language_size
  texturing:
    doc-ref: clause 17.5
    seq:
      - id: threshold
        type: f8
      - id: depth_bias
        type: f8
      - id: depth_slope
        type: f8
      - id: inset
        type: f8
      - id: best
        type: u1
        valid:
          min: 1
      - id: unseen
        type: u1
        repeat: expr
        repeat-expr: 3
      - id: blend
        type: u1
        valid:
          max: 1
      - id: reserved
        type: u1
        valid: 0
        repeat: expr
        repeat-expr: 3
  group:
    doc-ref: clause 6.1
    seq:
      - id: sequence
        type: u4
      - id: configuration_crc
        type: u4
      - id: start
        type: s8
      - id: end
        type: s8
  group_end:
    doc-ref: clause 6.3
    seq:
      - id: sequence
        type: u4
      - id: chunk_count
        type: u4
      - id: chain_crc
        type: u4
      - id: frame_count
        type: u4
      - id: kind_count
        type: u4
      - id: table_size
        type: u4
      - id: rows
        type: group_row
        repeat: expr
        repeat-expr: kind_count
      - id: table
        type: chunk_table
        size: table_size
  group_row:
    seq:
      - id: type
        type: str
        size: 4
        encoding: ASCII
      - id: track
        type: u2
      - id: flags
        type: chunk_flags
        size: 1
      - id: reserved
        type: u1
        valid: 0
  chunk_table:
    seq:
      - id: entries
        type: chunk_entry
        repeat: eos
  chunk_entry:
    seq:
      - id: row
        type: uleb128
      - id: payload_size
        type: uleb128
      - id: time_difference
        doc: A zigzag number.
        type: uleb128
  index:
    doc-ref: clause 7.1
    seq:
      - id: group_count
        type: u4
      - id: block_count
        type: u4
      - id: blocks
        type: index_block
        repeat: expr
        repeat-expr: block_count
      - id: entries
        type: index_entry
        repeat: expr
        repeat-expr: group_count
  index_block:
    seq:
      - id: offset
        type: u8
      - id: block_size
        type: u4
      - id: digest
        type: u4
  index_entry:
    seq:
      - id: offset
        type: u8
      - id: group_size
        type: u8
      - id: start
        type: s8
      - id: end
        type: s8
      - id: sequence
        type: u4
      - id: frame_count
        type: u4
      - id: chain_crc
        type: u4
      - id: end_size
        type: u4
      - id: block
        type: u4
        valid:
          max: _parent.block_count - 1
  footer:
    doc-ref: clause 7.2
    seq:
      - id: index_offset
        type: u8
      - id: file_size
        type: u8
      - id: index_crc
        type: u4
      - id: reserved
        type: u4
        valid: 0
  mesh:
    doc-ref: clause 8.3
    seq:
      - id: profile
        type: u1
        enum: profile
      - id: attributes
        type: mesh_attributes
        size: 1
      - id: texture_bits
        type: u1
        valid:
          max: 16
      - id: normal_bits
        type: u1
        valid:
          max: 12
      - id: vertex_count
        type: u4
      - id: face_count
        type: u4
      - id: reserved
        type: u4
        valid: 0
      - id: data
        size-eos: true
        type:
          switch-on: profile
          cases:
            "profile::raw": raw_mesh
            "profile::delta": delta_mesh
            "profile::fast": fast_mesh
            "profile::patched": patched_mesh
  mesh_attributes:
    meta:
      bit-endian: le
    seq:
      - id: texture
        type: b1
      - id: normals
        type: b1
      - id: reserved
        type: b6
        valid: 0
  pair:
    seq:
      - id: first
        type: u4
      - id: second
        type: u4
  position:
    seq:
      - id: x
        type: s4
      - id: y
        type: s4
      - id: z
        type: s4
  face:
    seq:
      - id: corners
        type: u4
        repeat: expr
        repeat-expr: 3
  raw_mesh:
    seq:
      - id: positions
        type: position
        repeat: expr
        repeat-expr: _parent.as<mesh>.vertex_count
      - id: texture
        type: pair
        repeat: expr
        repeat-expr: "_parent.as<mesh>.attributes.texture ? _parent.as<mesh>.vertex_count : 0"
      - id: normals
        type: pair
        repeat: expr
        repeat-expr: "_parent.as<mesh>.attributes.normals ? _parent.as<mesh>.vertex_count : 0"
      - id: faces
        type: face
        repeat: expr
        repeat-expr: _parent.as<mesh>.face_count
  delta_mesh:
    doc-ref: clause 8.7
    seq:
      - id: number
        type: uleb128
      - id: level_count
        type: uleb128
      - id: levels
        type: delta_level
        repeat: expr
        repeat-expr: level_count.value
      - id: data
        size: levels[_index].size.value
        repeat: expr
        repeat-expr: level_count.value
  delta_level:
    seq:
      - id: step
        type: uleb128
      - id: size
        type: uleb128
  fast_mesh:
    doc-ref: clause 8.11
    seq:
      - id: len_vertex_stream
        type: u4
      - id: vertex_stream
        size: len_vertex_stream
      - id: index_stream
        size-eos: true
  patched_mesh:
    doc-ref: clause 8.14
    seq:
      - id: absent_size
        type: uleb128
      - id: patch_size
        type: uleb128
      - id: absent
        type: runs
        size: absent_size.value
      - id: patch
        type: mesh
        size: patch_size.value
        if: patch_size.value > 0
      - id: delta
        type: delta_mesh
        size-eos: true
  runs:
    seq:
      - id: lengths
        type: uleb128
        repeat: eos
  calibration:
    doc-ref: clause 9.4
    seq:
      - id: number
        type: u2
      - id: rotation_bits
        type: u1
        valid:
          min: 8
          max: 25
      - id: position_bits
        type: u1
        valid:
          max: 40
      - id: pixel_bits
        type: u1
        valid:
          max: 40
      - id: lens_bits
        type: u1
        valid:
          max: 40
      - id: count
        type: u2
      - id: numbers
        doc: Of each entry the camera, then zigzag numbers, as many as the lens model of the camera has.
        type: uleb128
        repeat: eos
  visibility:
    doc-ref: clause 17.1
    seq:
      - id: reserved
        type: u1
        valid: 0
      - id: threshold
        type: u1
      - id: mesh_track
        type: u2
      - id: vertex_count
        type: u4
      - id: number
        type: u4
      - id: camera_count
        type: u4
        valid:
          min: 1
      - id: pairs
        type: visibility_pair
        repeat: expr
        repeat-expr: camera_count
      - id: streams
        size: pairs[_index].size.value
        repeat: expr
        repeat-expr: camera_count
  visibility_pair:
    seq:
      - id: camera
        type: uleb128
      - id: size
        type: uleb128
  colours:
    doc-ref: clause 19.1
    seq:
      - id: luma_step
        type: u1
        valid:
          min: 1
          max: 64
      - id: chroma_step
        type: u1
        valid:
          min: 1
          max: 64
      - id: mesh_track
        type: u2
      - id: vertex_count
        type: u4
      - id: cell_size
        type: u4
      - id: cell_count
        type: u4
      - id: data
        size-eos: true
  environment:
    doc-ref: clause 18.1
    seq:
      - id: lattice_origin
        type: vector
      - id: lattice_step
        type: f8
      - id: part_count
        type: u4
      - id: picture_count
        type: u4
      - id: light_count
        type: u4
      - id: reserved
        type: u4
        valid: 0
      - id: parts
        type: environment_part
        repeat: expr
        repeat-expr: part_count
      - id: pictures
        type: environment_picture
        repeat: expr
        repeat-expr: picture_count
      - id: lights
        type: light
        repeat: expr
        repeat-expr: light_count
      - id: meshes
        type: mesh
        size: parts[_index].mesh_size
        repeat: expr
        repeat-expr: part_count
      - id: files
        size: pictures[_index].bytes
        repeat: expr
        repeat-expr: picture_count
  environment_part:
    seq:
      - id: mesh_size
        type: u4
      - id: picture
        type: u4
      - id: colour
        type: u2
        repeat: expr
        repeat-expr: 3
      - id: flags
        type: u1
        valid:
          max: 7
      - id: reserved
        type: u1
        valid: 0
      - id: texture_origin
        type: f8
        repeat: expr
        repeat-expr: 2
      - id: texture_size
        type: f8
        repeat: expr
        repeat-expr: 2
  environment_picture:
    seq:
      - id: codec
        type: u1
        enum: picture_codec
      - id: reserved
        type: u1
        valid: 0
        repeat: expr
        repeat-expr: 3
      - id: width
        type: u4
      - id: height
        type: u4
      - id: bytes
        type: u4
  light:
    doc-ref: clause 18.4
    seq:
      - id: type
        type: u1
        enum: light_type
      - id: flags
        type: u1
        valid:
          max: 1
      - id: reserved
        type: u1
        valid: 0
        repeat: expr
        repeat-expr: 6
      - id: position
        type: vector
      - id: direction
        type: vector
      - id: colour
        type: vector
      - id: intensity
        type: f8
      - id: range
        type: f8
      - id: inner_cone
        type: f8
      - id: outer_cone
        type: f8
  packets:
    doc-ref: clause 20.2
    doc: Whether a position precedes the sizes depends on the flags of the track's ACFG, so that they are bytes here.
    seq:
      - id: start
        type: s8
      - id: packet_count
        type: u4
        valid:
          min: 1
      - id: preroll_count
        type: u4
        valid:
          max: packet_count - 1
      - id: body
        size-eos: true
  data:
    doc-ref: clause 21.1
    doc: The payload of DATA is bytes of another format.
    seq:
      - id: media_type_size
        type: u2
        valid:
          min: 1
      - id: codec_size
        type: u2
      - id: record_size
        type: u4
      - id: record
        size: record_size
      - id: media_type
        type: str
        size: media_type_size
      - id: codec
        type: str
        size: codec_size
enums:
  up_axis:
    0: unknown
    1: x
    2: y
    3: z
    4: minus_x
    5: minus_y
    6: minus_z
  track_kind:
    1: mesh
    2: video
    3: calibration
    4: visibility
    5: environment
    6: data
    7: audio
    8: colours
  lens:
    0: none
    1: radtan
    2: fisheye
  shows:
    0: tiles
    1: atlas
  profile:
    0: raw
    1: draco
    2: delta
    3: field
    4: fast
    5: patched
  picture_codec:
    0: jpeg
    1: png
  light_type:
    0: directional
    1: point
    2: spot
