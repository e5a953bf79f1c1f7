// Includes a folder that this target does not link: must not compile (tests/CMakeLists.txt).
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/scene.h"
