// Lines along a principal direction (thesis section 6.4.2, "Curvature-aligned flow advection"): the
// noise of flow_noise.frag, convolved along them in the picture.
// SPDX-License-Identifier: MPL-2.0
// source  Cabral and Leedom 1993, "Imaging vector fields using line integral convolution", with their
//         window and, where it travels, their ripple; the thesis moves the picture before along
//         instead (van Wijk 2003), which needs many frames and sticks to the screen
#version 450 core

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_direction;
layout(binding = 2) uniform sampler2D t_noise;
// DIRECTION: of which principal curvature, 1 or 2
#if DIRECTION == 2
layout(binding = 3) uniform sampler2D t_gradient;
#endif
uniform mat3 u_screen;    // eye-relative positions [world] to (pixels times depth, depth)
uniform float u_depth;    // to be added to that depth: 1 in parallel projection, whose row is 0
uniform int u_steps;      // to either side, of one pixel
uniform float u_contrast; // for a window of one pixel [1/sqrt(pixel)]
// TRAVELS: 1 for a picture that moves along the lines with u_phase, by a ripple of the kernel in 0 ... 1
#if TRAVELS
uniform float u_phase;
uniform vec3 u_forward; // lines run to the side of this, unit, world axes
#endif

out vec4 o_flow; // factor of the colour, 1 on average; coverage

const float pi = 3.14159265;
// Lines fade where the curvatures differ by less of themselves: there directions are of noise.
const float certain_difference = 0.1;

// Principal direction, unit, world axes; how far the curvatures differ.
vec4 direction_at(ivec2 pixel) {
    vec4 d = texelFetch(t_direction, pixel, 0);
#if DIRECTION == 2
    vec3 across = cross(texelFetch(t_gradient, pixel, 0).xyz, d.xyz);
    d.xyz = across / max(length(across), 1e-30); // 1e-30: no division by zero
#endif
    return d;
}

// The noise between four pixels, at a place `off` a pixel's middle.
float noise_at(ivec2 pixel, vec2 off) {
    vec2 below = floor(off);
    vec2 a = off - below;
    vec2 corner = vec2(pixel + ivec2(below) + 1); // where they meet
    vec4 t = textureGather(t_noise, corner / vec2(textureSize(t_noise, 0)));
    return mix(mix(t.w, t.z, a.x), mix(t.x, t.y, a.x), a.y);
}

// The kernel at s in [-1, 1].
float kernel(float s) {
    float window = 0.5 + 0.5 * cos(pi * s);
#if TRAVELS
    return window * (0.5 + 0.5 * cos(2.0 * pi * (s + u_phase))); // what it shows moves forward
#else
    return window;
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 size = textureSize(t_hit, 0);
    vec4 hit = texelFetch(t_hit, pixel, 0);
    vec4 middle = direction_at(pixel);
    o_flow = vec4(1.0, 1.0, 1.0, 0.0);
    // Umbilics have no direction.
    if (hit.w == 0.0 || !(middle.w > 0.0)) return;
#if TRAVELS
    if (dot(middle.xyz, u_forward) < 0.0) middle.xyz = -middle.xyz;
#endif
    float weight = kernel(0.0);
    float sum = weight * texelFetch(t_noise, pixel, 0).r;
    float squares = weight * weight;
    float window = 1.0; // of which the line has so much
    for (int side = -1; side <= 1; side += 2) {
        vec3 p = hit.xyz;
        vec3 d = float(side) * middle.xyz;
        vec2 off = vec2(0.0); // not from the corner of the part that is drawn, which would round it
        for (int i = 1; i <= u_steps; ++i) {
            // How d moves in the picture [pixels/world].
            vec3 q = u_screen * p + vec3(0.0, 0.0, u_depth);
            vec3 dq = u_screen * d;
            vec2 velocity = (dq.xy - q.xy * (dq.z / q.z)) / q.z;
            float speed = length(velocity);
            off += velocity / max(speed, 1e-30);
            ivec2 next = pixel + ivec2(floor(off + 0.5));
            if (any(lessThan(next, ivec2(0))) || any(greaterThanEqual(next, size))) break;
            vec4 next_hit = texelFetch(t_hit, next, 0);
            vec4 next_direction = direction_at(next);
            // Lines end at another object, at an umbilic, and where the surface is not near where
            // the tangent leads: at a silhouette. 8: a pixel's rounding moves it by as much where
            // it is seen at 83 degrees.
            vec3 way = d / max(speed, 1e-30);
            if (next_hit.w != hit.w || !(next_direction.w > 0.0) ||
                distance(next_hit.xyz, p + way) > 8.0 * length(way))
                break;
            p = next_hit.xyz;
            // A direction is a line without a sense: the one that goes on.
            d = dot(next_direction.xyz, d) < 0.0 ? -next_direction.xyz : next_direction.xyz;
            float s = float(i) / float(u_steps + 1);
            weight = kernel(float(side) * s);
            sum += weight * noise_at(pixel, off);
            squares += weight * weight;
            window += 0.5 + 0.5 * cos(pi * s);
        }
    }
    // 1e-30: a ripple may be nothing where the line is one pixel.
    float factor = 1.0 + clamp(u_contrast * sum * inversesqrt(max(squares, 1e-30)), -0.9, 0.9);
    // The window's sum is u_steps + 1; half of it is a line.
    float is_line = smoothstep(0.0, 0.5, window / float(u_steps + 1));
    o_flow = vec4(vec3(factor), is_line * smoothstep(0.0, certain_difference, middle.w));
}
