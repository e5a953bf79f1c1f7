// Noise in space.
// SPDX-License-Identifier: MPL-2.0

// source  Jarzynski & Olano, "Hash Functions for GPU Rendering", JCGT 2020: pcg3d
uvec3 hash(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Of period 256 along each axis, zero at integers, between -1 and 1 about; two continuous
// derivatives.
// source  Perlin, "Improving Noise", 2002: the fade; gradients are not normalised
float noise(vec3 p) {
    vec3 cell = floor(p);
    vec3 a = p - cell;
    vec3 fade = a * a * a * (a * (a * 6.0 - 15.0) + 10.0);
    float sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        ivec3 at = ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
        // The highest bits are the best ones; 2^23 of them have a float each.
        vec3 gradient = vec3(hash(uvec3((ivec3(cell) + at) & 255)) >> 8u) / 8388608.0 - 1.0;
        vec3 weight = mix(1.0 - fade, fade, vec3(at));
        sum += weight.x * weight.y * weight.z * dot(gradient, a - vec3(at));
    }
    return sum;
}

// What a pixel that is `width` wide sees of a wave of `frequency`: nothing beyond half a period.
float visible_share(float frequency, float width) {
    return 1.0 - smoothstep(0.25, 0.5, frequency * width);
}
