// What tests of pictures draw with.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/renderer.h"
#include "test_context.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

namespace isocast::test {

inline const std::filesystem::path shader_folder =
    std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

struct RendererTest : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, shader_folder};
};

} // namespace isocast::test
