// The rectangle of samples in which one slice meets the region of one site (thesis section 4.2.4).
// SPDX-License-Identifier: MPL-2.0
// twin  distance_transform/gl/site_sections.h: GpuSite, Section
#version 450 core

const int tile_size = 64; // distance_transform/gl/slab_tiles.h

struct Site {
    ivec4 cell;           // its own origin, in samples of the tile; w the tile's slot in the target
    vec4 base_min;        // from the cell; w the least height
    vec4 base_max;        // w the greatest height
    vec4 direction;       // of heights; w the lateral offset at height 0
    vec4 lateral_factor;  // w how the lateral offset grows with height
    vec4 functions[4];    // gradients, and values at the cell
    int number;
    float error;          // bound on what float does to any of the functions
    float unused[2];
};
layout(std430, binding = 0) readonly buffer Sites { Site sites[]; };
layout(std430, binding = 1) readonly buffer Sections { uvec2 sections[]; }; // site, slice

uniform int u_first_section;
uniform int u_slab_height;   // slices of a tile
uniform int u_slot_columns;  // tiles beside each other in the target
uniform vec2 u_target_size;

flat out vec4 v_value;       // of the functions at the first sample of the rectangle
flat out vec4 v_along_x;
flat out vec4 v_along_y;
flat out vec2 v_first_pixel;
flat out float v_error;
flat out ivec4 v_sample;     // first sample within the tile; w the tile's slot
flat out int v_site;

void main() {
    uvec2 section = sections[u_first_section + gl_InstanceID];
    Site site = sites[section.x];
    vec3 w = site.direction.xyz;
    float z = float(int(section.y) - site.cell.z);

    // Heights of the region at which it meets the slice, as in for_each_cell of sites.h.
    float low = site.base_min.w;
    float high = site.base_max.w;
    float slope = site.lateral_factor.w;
    float aside = (site.direction.w + slope * max(-low, high)) * site.lateral_factor.z;
    // Below 0.01 of an upright direction the slice says little about heights.
    if (abs(w.z) > 0.01) {
        float a = (z - site.base_max.z - aside) / w.z;
        float b = (z - site.base_min.z + aside) / w.z;
        low = max(low, min(a, b));
        high = min(high, max(a, b));
    }
    vec2 lateral = (site.direction.w + slope * max(-low, high)) * site.lateral_factor.xy;
    vec2 least = site.base_min.xy + min(low * w.xy, high * w.xy) - lateral - site.error;
    vec2 greatest = site.base_max.xy + max(low * w.xy, high * w.xy) + lateral + site.error;
    ivec2 first = clamp(ivec2(ceil(least)) + site.cell.xy, 0, tile_size);
    ivec2 end = clamp(ivec2(floor(greatest)) + site.cell.xy + 1, 0, tile_size);
    if (low > high) end = first;

    int slot = site.cell.w;
    ivec2 slot_pixel = ivec2(slot % u_slot_columns, slot / u_slot_columns) *
                           ivec2(tile_size, tile_size * u_slab_height) +
                       ivec2(0, tile_size * int(section.y));
    // Sample p is the middle of pixel p: a rectangle of whole pixels covers just its samples.
    ivec2 corner = mix(first, end, notEqual(gl_VertexID & ivec2(1, 2), ivec2(0)));
    gl_Position = vec4(2.0 * vec2(slot_pixel + corner) / u_target_size - 1.0, 0.0, 1.0);

    vec3 q = vec3(vec2(first - site.cell.xy), z);
    for (int i = 0; i < 4; ++i) {
        v_value[i] = dot(site.functions[i].xyz, q) + site.functions[i].w;
        v_along_x[i] = site.functions[i].x;
        v_along_y[i] = site.functions[i].y;
    }
    v_first_pixel = vec2(slot_pixel + first) + 0.5;
    v_error = site.error;
    v_sample = ivec4(first, int(section.y), slot);
    v_site = site.number;
}
