// A face of an active block (thesis section 6.3.1).
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/bounding_faces.cpp
#version 450 core

const float block_size = 8.0; // volume/sparse_field.h

layout(location = 0) in ivec4 face; // xyz the block's low corner, w 2 * axis + (high ? 1 : 0)
uniform mat4 u_clip_from_local;
out vec3 v_p_local;
flat out int v_face;

void main() {
    int axis = face.w >> 1;
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * block_size;
    vec3 offset = vec3(0.0);
    offset[axis] = float(face.w & 1) * block_size;
    offset[(axis + 1) % 3] = corner.x;
    offset[(axis + 2) % 3] = corner.y;
    v_p_local = vec3(face.xyz) + offset;
    v_face = face.w;
    gl_Position = u_clip_from_local * vec4(v_p_local, 1.0);
    // Depth is compared by blending: nothing is clipped at a near or far plane, only behind the eye.
    gl_Position.z = 0.0;
}
