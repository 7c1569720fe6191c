#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes the same box in every mesh format, for tests/sim/world/mesh_test.cc.

The box reaches from (0.1, -0.2, 0) to (0.7, 0.3, 0.4) metres with z up; every face shows the whole of
quarters.png upright (upper edge up; on top and bottom towards +y), seen from outside.
Formats with y up hold (x, y, z) as (x, z, -y). The ones called `_mm` and `_z` are in millimetres
and with z up, and say so where the format can.
"""
import base64
import json
import struct
import zlib

LOW, HIGH = (0.1, -0.2, 0.0), (0.7, 0.3, 0.4)
P = [(x, y, z) for z in (LOW[2], HIGH[2])
     for x, y in ((LOW[0], LOW[1]), (HIGH[0], LOW[1]), (HIGH[0], HIGH[1]), (LOW[0], HIGH[1]))]
FACES = [(1, 2, 6, 5), (3, 0, 4, 7), (2, 3, 7, 6), (0, 1, 5, 4), (4, 5, 6, 7), (1, 0, 3, 2)]
UV = [(0, 0), (1, 0), (1, 1), (0, 1)]  # upwards from the lower left


def y_up(p):
    return (p[0], p[2], -p[1])


def chunk(kind, data):
    return struct.pack('>I', len(data)) + kind + data + struct.pack(
        '>I', zlib.crc32(kind + data))


def png():
    """Upper left red, upper right green, lower left blue, lower right white."""
    upper = b'\0' + b'\xff\0\0' * 4 + b'\0\xff\0' * 4
    lower = b'\0' + b'\0\0\xff' * 4 + b'\xff\xff\xff' * 4
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', 8, 8, 8, 2, 0, 0, 0)) +
            chunk(b'IDAT', zlib.compress(upper * 4 + lower * 4)) + chunk(b'IEND', b''))


def write(name, data):
    with open(name, 'wb') as file:
        file.write(data if isinstance(data, bytes) else data.encode())


def obj():
    lines = ['mtllib box.mtl']
    lines += ['v %g %g %g' % y_up(p) for p in P]
    lines += ['vt %g %g' % uv for uv in UV] + ['usemtl paint']
    lines += ['f ' + ' '.join(f'{v + 1}/{i + 1}' for i, v in enumerate(face)) for face in FACES]
    return '\n'.join(lines) + '\n'


def gltf(embedded, glb=False, mirrored=False):
    """Four corners to a face, cut into two triangles. With `mirrored` the box is stored with x
    the other way round, and the node turns it back."""
    sign = -1 if mirrored else 1
    positions, uvs, indices = b'', b'', b''
    for f, face in enumerate(FACES):
        for i, v in enumerate(face):
            x, y, z = y_up(P[v])
            positions += struct.pack('<fff', sign * x, y, z)
            uvs += struct.pack('<ff', UV[i][0], 1 - UV[i][1])
        order = (0, 1, 2, 0, 2, 3) if not mirrored else (0, 2, 1, 0, 3, 2)
        indices += struct.pack('<6H', *[4 * f + i for i in order])
    data = positions + uvs + indices
    views = [(0, len(positions)), (len(positions), len(uvs)),
             (len(positions) + len(uvs), len(indices))]
    image = {'uri': 'quarters.png'}
    if embedded and glb:
        views.append((len(data), len(png())))
        data += png()
        image = {'bufferView': 3, 'mimeType': 'image/png'}
    elif embedded:
        image = {'uri': 'data:image/png;base64,' + base64.b64encode(png()).decode()}
    data += b'\0' * (-len(data) % 4)
    buffer = {'byteLength': len(data)}
    if not glb:
        buffer['uri'] = ('data:application/octet-stream;base64,' +
                         base64.b64encode(data).decode())
    xs = [sign * LOW[0], sign * HIGH[0]]
    doc = {
        'asset': {'version': '2.0'}, 'scene': 0, 'scenes': [{'nodes': [0]}],
        'nodes': [{'mesh': 0, 'scale': [sign, 1, 1]}],
        'meshes': [{'primitives': [{'attributes': {'POSITION': 0, 'TEXCOORD_0': 1},
                                    'indices': 2, 'material': 0}]}],
        'materials': [{'name': 'paint',
                       'pbrMetallicRoughness': {'baseColorTexture': {'index': 0}}}],
        'textures': [{'source': 0}], 'images': [image], 'buffers': [buffer],
        'bufferViews': [{'buffer': 0, 'byteOffset': at, 'byteLength': n} for at, n in views],
        'accessors': [
            {'bufferView': 0, 'componentType': 5126, 'count': 24, 'type': 'VEC3',
             'min': [min(xs), LOW[2], -HIGH[1]], 'max': [max(xs), HIGH[2], -LOW[1]]},
            {'bufferView': 1, 'componentType': 5126, 'count': 24, 'type': 'VEC2'},
            {'bufferView': 2, 'componentType': 5123, 'count': 36, 'type': 'SCALAR'}]}
    text = json.dumps(doc, indent=None if glb else 1).encode()
    if not glb:
        return text
    text += b' ' * (-len(text) % 4)
    body = (struct.pack('<II', len(text), 0x4E4F534A) + text +
            struct.pack('<II', len(data), 0x004E4942) + data)
    return struct.pack('<III', 0x46546C67, 2, 12 + len(body)) + body


def dae(z_is_up, unit_m):
    points = [p if z_is_up else y_up(p) for p in P]
    numbers = ' '.join('%g' % (c / unit_m) for p in points for c in p)
    corners = ' '.join(f'{v} {i}' for face in FACES for i, v in enumerate(face))
    return f'''<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="unit" meter="{unit_m}"/><up_axis>{'Z_UP' if z_is_up else 'Y_UP'}</up_axis></asset>
  <library_images><image id="quarters"><init_from>quarters.png</init_from></image></library_images>
  <library_effects><effect id="paint-effect"><profile_COMMON>
    <newparam sid="surface"><surface type="2D"><init_from>quarters</init_from></surface></newparam>
    <newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>
    <technique sid="common"><lambert><diffuse><texture texture="sampler" texcoord="uv"/></diffuse></lambert></technique>
  </profile_COMMON></effect></library_effects>
  <library_materials><material id="paint" name="paint"><instance_effect url="#paint-effect"/></material></library_materials>
  <library_geometries><geometry id="box"><mesh>
    <source id="points"><float_array id="points-array" count="24">{numbers}</float_array>
      <technique_common><accessor source="#points-array" count="8" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <source id="uvs"><float_array id="uvs-array" count="8">0 0 1 0 1 1 0 1</float_array>
      <technique_common><accessor source="#uvs-array" count="4" stride="2">
        <param name="S" type="float"/><param name="T" type="float"/>
      </accessor></technique_common></source>
    <vertices id="vertices"><input semantic="POSITION" source="#points"/></vertices>
    <polylist material="paint" count="6">
      <input semantic="VERTEX" source="#vertices" offset="0"/>
      <input semantic="TEXCOORD" source="#uvs" offset="1" set="0"/>
      <vcount>4 4 4 4 4 4</vcount><p>{corners}</p>
    </polylist>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="scene"><node id="node">
    <instance_geometry url="#box"><bind_material><technique_common>
      <instance_material symbol="paint" target="#paint"><bind_vertex_input semantic="uv" input_semantic="TEXCOORD" input_set="0"/></instance_material>
    </technique_common></bind_material></instance_geometry>
  </node></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
'''


def ply():
    lines = ['ply', 'format ascii 1.0', 'comment TextureFile quarters.png', 'element vertex 24']
    lines += [f'property float {name}' for name in ('x', 'y', 'z', 's', 't')]
    lines += ['element face 6', 'property list uchar int vertex_indices', 'end_header']
    lines += ['%g %g %g %g %g' % (*P[v], *UV[i]) for face in FACES for i, v in enumerate(face)]
    lines += ['4 %d %d %d %d' % tuple(4 * f + i for i in range(4)) for f in range(6)]
    return '\n'.join(lines) + '\n'


def stl_triangles(unit_m):
    for a, b, c, d in FACES:
        for triangle in ((a, b, c), (a, c, d)):
            yield [tuple(x / unit_m for x in P[v]) for v in triangle]


def stl_text(unit_m):
    lines = ['solid box']
    for triangle in stl_triangles(unit_m):
        lines += ['facet normal 0 0 0', 'outer loop']
        lines += ['vertex %g %g %g' % p for p in triangle]
        lines += ['endloop', 'endfacet']
    return '\n'.join(lines + ['endsolid box']) + '\n'


def stl_binary():
    triangles = list(stl_triangles(1))
    return b'box'.ljust(80, b'\0') + struct.pack('<I', len(triangles)) + b''.join(
        struct.pack('<12fH', 0, 0, 0, *[c for p in triangle for c in p], 0)
        for triangle in triangles)


write('quarters.png', png())
write('box.mtl', 'newmtl paint\nmap_Kd quarters.png\n')
write('box.obj', obj())
write('box.gltf', gltf(embedded=False))
write('box_embedded.gltf', gltf(embedded=True))
write('box_mirrored.gltf', gltf(embedded=True, mirrored=True))
write('box.glb', gltf(embedded=True, glb=True))
write('box.dae', dae(z_is_up=False, unit_m=1))
write('box_z_mm.dae', dae(z_is_up=True, unit_m=0.001))
write('box.ply', ply())
write('box_mm.stl', stl_text(0.001))
write('box.stl', stl_binary())
