// Where in the picture a pixel's ray passes. gl_FragCoord counts from the corner of the part that is
// drawn, and is for texels alone.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/camera.h: PicturePart
uniform vec2 u_first_pixel; // of the part, from the picture's bottom left corner; and the rays' shift

// Exact: both are multiples of 1/128 below 2^17.
vec2 picture_pixel() { return gl_FragCoord.xy + u_first_pixel; }
