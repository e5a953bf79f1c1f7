// Pictures of fields whose bricks do not all fit: a pixel that needs a missing brick says so and waits
// for the next pass.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/passes.cpp: draw_streamed()

// For each active block, 1 if a pixel waits for it, 2 if one read it.
layout(std430, binding = 0) buffer Visits { uint visits[]; };
// What a pixel goes on with: not_started, is_finished, or a number of its own.
layout(binding = 0, r32i) uniform iimage2D i_progress;

const int not_started = -1;
const int is_finished = 0x7fffffff;

int progress_of_pixel() { return imageLoad(i_progress, ivec2(gl_FragCoord.xy)).r; }

void set_progress(int progress) {
    imageStore(i_progress, ivec2(gl_FragCoord.xy), ivec4(progress));
}

// False if the block's brick is missing.
bool visit(int block, bool is_resident) {
    visits[block] = is_resident ? 2u : 1u;
    return is_resident;
}
