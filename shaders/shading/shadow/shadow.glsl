// Share of a light that reaches a point, by percentage-closer filtering of the shadow map (thesis
// section 7.3.2).
// SPDX-License-Identifier: MPL-2.0
// docs  docs/shadows.md
#include "common/pixel.glsl"
#include "shading/disc.glsl"
//
// IS_SOFT: whether the light has a size.

layout(binding = 2) uniform sampler2D t_shadow_map;
// Light space: x, y as gl_FragCoord of the shadow map, z down from the light's plane; all [texels].
uniform mat3 u_light_from_world;
uniform vec3 u_eye_light;
#if IS_SOFT
uniform float u_spread; // tangent of half the angle under which the light is seen
#endif

// What receives light.
struct Receiver {
    vec3 p;     // in light space
    vec2 slope; // of its tangent plane: dz by dx, dy
    // A texel's light meets this stretch of the plane [texels]. Surfaces that are closer than that are
    // not told apart, so this is how far below others a receiver in their shadow must be: filters look
    // at samples up to a texel off, where a bent surface is not on its plane.
    float footprint;
};

// What the light sees in a texel.
struct Seen {
    float height;  // over the receiver [texels]
    bool is_above; // it is in front of the receiver's tangent plane
    float offset;  // how far off, sideways [texels]
};

Seen look_up(Receiver r, vec2 place) {
    // The map's border is empty.
    ivec2 texel = clamp(ivec2(floor(place)), ivec2(0), textureSize(t_shadow_map, 0) - 1);
    vec2 off = vec2(texel) + 0.5 - r.p.xy;
    float depth = texelFetch(t_shadow_map, texel, 0).r;
    return Seen(r.p.z - depth, r.p.z + dot(r.slope, off) - depth > r.footprint, length(off));
}

#if IS_SOFT
const int first_count = 8;
const int all_count = 64;

// How far off, sideways, an occluder may be that hides a part of the light [texels]; a texel at least,
// so that the shadow's edge is as smooth as the map can tell.
float reach(float height) { return max(u_spread * height, 1.0); }

// Eight samples find the lowest occluder in the cone of directions to the light, and whether there are
// ways past it. Height and offset of one say which point of the light it hides; so what is counted in
// full light has nothing before it. If there is a way past an occluder, the others average over the
// light's disc as it falls, through the receiver, on the plane at the occluder's height.
vec2 filtered(Receiver r, float turns) {
    float lowest = r.p.z; // no occluder is higher than the light's plane
    float nearest_gap = 1e30;
    bool is_hidden = false; // some of the light is
    float direction = turns;
    for (int i = 0; i < first_count; ++i) {
        // The middle, then a ring of seven: 0.85 of the disc, so that what is a little lower there
        // is in the cone too; less 0.7, half a texel's diagonal. What hides a straight edge's share of
        // the disc is seen from 6.5 % on, where 0.85 cos(pi/7) of the radius is left.
        float radius = i == 0 ? 0.0 : 0.85 * reach(lowest) - 0.7;
        Seen seen = look_up(r, r.p.xy + on_disc(radius, direction));
        // 4: as far outside the cone it tells how high occluders are. A surface that rises faster is
        // taken for one, one that rises more slowly for the receiver's own.
        bool is_occluder = seen.is_above && seen.offset <= 4.0 * reach(seen.height);
        bool is_in_cone = is_occluder && seen.offset <= reach(seen.height);
        is_hidden = is_hidden || is_in_cone;
        lowest = is_occluder ? min(lowest, seen.height) : lowest;
        nearest_gap = is_occluder ? nearest_gap : min(nearest_gap, seen.offset);
        // What lies outside the cone is looked for inside next.
        direction += is_occluder && !is_in_cone ? 0.0 : 3.0 / float(first_count - 1);
    }
    bool is_penumbra = is_hidden && nearest_gap <= reach(lowest);
    int count = is_penumbra ? all_count - first_count : 0;
    float lit = 0.0;
    for (int i = 0; i < count; ++i) {
        Seen seen = look_up(r, r.p.xy + reach(lowest) * disc_point(i, count, turns));
        // Half way up is between the occluder and the receiver's own surface.
        lit += seen.is_above && seen.height > 0.5 * lowest ? 0.0 : 1.0;
    }
    float share = is_penumbra ? lit / float(all_count - first_count) : is_hidden ? 0.0 : 1.0;
    return vec2(share, first_count + count);
}
#else
// The four nearest texels, by their weights in bilinear interpolation.
vec2 filtered(Receiver r, float turns) {
    vec2 corner = floor(r.p.xy - 0.5) + 0.5;
    vec2 weight = r.p.xy - corner;
    vec4 lit;
    for (int i = 0; i < 4; ++i)
        lit[i] = look_up(r, corner + vec2(i & 1, i >> 1)).is_above ? 0.0 : 1.0;
    vec2 row = mix(lit.xz, lit.yw, weight.x);
    return vec2(mix(row.x, row.y, weight.y), 4.0);
}
#endif

// Share of the light, samples taken.
//
// p          from the eye [world]
// gradient   of the surface there, world axes
// direction  of the ray
vec2 light_share(bool is_hit, vec3 p, vec3 gradient, vec3 direction) {
    // As in shading.frag: where the gradient vanishes, and seen from inside.
    vec3 normal = dot(gradient, gradient) > 0.0 ? gradient : -direction;
    normal = u_light_from_world * (dot(normal, direction) > 0.0 ? -normal : normal);
    // Surfaces that turn away get no light, which needs no samples.
    bool is_facing = is_hit && normal.z < 0.0;
    vec2 share = vec2(is_hit ? 0.0 : 1.0, 0.0);
    while (is_facing) { // a loop for a condition: see derivatives.frag
        vec2 slope = -normal.xy / normal.z;
        Receiver r = Receiver(u_light_from_world * p + u_eye_light, slope, sqrt(1.0 + dot(slope, slope)));
        share = filtered(r, turns_of_pixel(picture_pixel()));
        is_facing = share.y < 0.0; // never
    }
    return share;
}
