// The rectangle of samples in which one slice meets the region of one site (thesis section 4.2.4).
// SPDX-License-Identifier: MPL-2.0
// twin  distance_transform/gl/site_sections.h: GpuSite
#version 450 core

const int tile_size = 32; // distance_transform/scan_kernel.h

layout(location = 0) in ivec4 cell;          // the tile's sample next to the site; w the slot
layout(location = 1) in vec4 base_min;       // from the cell; w the least height
layout(location = 2) in vec4 base_max;       // w the greatest height
layout(location = 3) in vec4 direction;      // of heights; w the lateral offset at height 0
layout(location = 4) in vec4 lateral_factor; // w how the lateral offset grows with height
layout(location = 5) in vec4 functions[4];   // gradients, and values at the cell
layout(location = 9) in ivec4 numbers;       // of the site, of its first slice, bits of the error

uniform int u_slot_columns; // tiles beside each other in the target
uniform vec2 u_target_size;

flat out vec4 v_value;       // of the functions at the first sample of the rectangle
flat out vec4 v_along_x;
flat out vec4 v_along_y;
flat out vec2 v_first_pixel;
flat out float v_error;
flat out ivec4 v_sample;     // first sample within the tile; w the tile's slot
flat out int v_site;

void main() {
    vec3 w = direction.xyz;
    int slice = numbers.y + (gl_VertexID >> 2);
    float error = intBitsToFloat(numbers.z); // bound on what float does to any of the functions
    float z = float(slice - cell.z);

    // Heights of the region at which it meets the slice, as in for_each_tile of band_tiles.cpp.
    float low = base_min.w;
    float high = base_max.w;
    float slope = lateral_factor.w;
    float aside = (direction.w + slope * max(-low, high)) * lateral_factor.z + error;
    // Below 0.01 of an upright direction the slice says little about heights.
    if (abs(w.z) > 0.01) {
        float a = (z - base_max.z - aside) / w.z;
        float b = (z - base_min.z + aside) / w.z;
        low = max(low, min(a, b));
        high = min(high, max(a, b));
    }
    vec2 lateral = (direction.w + slope * max(-low, high)) * lateral_factor.xy;
    vec2 least = base_min.xy + min(low * w.xy, high * w.xy) - lateral - error;
    vec2 greatest = base_max.xy + max(low * w.xy, high * w.xy) + lateral + error;
    ivec2 first = clamp(ivec2(ceil(least)) + cell.xy, 0, tile_size);
    ivec2 end = clamp(ivec2(floor(greatest)) + cell.xy + 1, 0, tile_size);
    if (low > high) end = first;

    int slot = cell.w;
    ivec2 slot_pixel = ivec2(slot % u_slot_columns, slot / u_slot_columns) *
                           ivec2(tile_size, tile_size * tile_size) +
                       ivec2(0, tile_size * slice);
    // Sample p is the middle of pixel p: a rectangle of whole pixels covers just its samples.
    ivec2 corner = mix(first, end, notEqual(gl_VertexID & ivec2(1, 2), ivec2(0)));
    gl_Position = vec4(2.0 * vec2(slot_pixel + corner) / u_target_size - 1.0, 0.0, 1.0);

    vec3 q = vec3(vec2(first - cell.xy), z);
    for (int i = 0; i < 4; ++i) {
        v_value[i] = dot(functions[i].xyz, q) + functions[i].w;
        v_along_x[i] = functions[i].x;
        v_along_y[i] = functions[i].y;
    }
    v_first_pixel = vec2(slot_pixel + first) + 0.5;
    v_error = error;
    v_sample = ivec4(first, slice, slot);
    v_site = numbers.x;
}
