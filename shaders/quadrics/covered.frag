// Each fragment of a splat's rectangle, whether it hits or not: to count them.
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(location = 0) out float o_covered;

void main() { o_covered = 1.0; }
