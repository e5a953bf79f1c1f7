// What a conversion reports, as text and as JSON.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/accuracy/promise.h"
#include "distance_transform/convert.h"
#include "distance_transform/meshless.h"
#include "volume/octree_interpolant.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>

namespace isocast {

struct ConvertReport {
    std::string input;
    std::filesystem::path output;
    MeshVerdict verdict;
    ConvertOptions options;
    SignMethod sign = SignMethod::Auto;
    std::string sign_reason = {};
    std::int64_t active_voxels = 0;
    Index3 size = Index3::Zero();
    struct {
        double read = 0;
        double prepare = 0;
        double transform = 0;
        double write = 0;
        double total = 0;
    } seconds = {};
    struct Points {
        std::size_t count = 0;
        bool normals_given = false;
        double median_spacing_world = 0;
        MeshlessOptions meshless;
    };
    std::optional<Points> points = {}; // instead of the verdict
    struct Octree {
        double max_error_world = 0;
        double finest_cell_world = 0;
        int depth = 0;
        double cells = 0;
        double nodes = 0;
        double free_nodes = 0; // that do not hang
        double bytes = 0;
        OctreeFilter filter = OctreeFilter::Linear;
        bool is_estimate = false;
    };
    std::optional<Promise> promise = {};          // of --max-error, but for octrees
    std::optional<Octree> octree = {};            // beside or instead of a band
    bool is_export = false;                       // of an octree file: there is no mesh
    std::optional<ConvertEstimate> expected = {}; // instead of a conversion
    std::vector<std::string> warnings = {};

    void take(SignMethod used, const std::string& reason, const std::vector<std::string>& more) {
        sign = used;
        sign_reason = reason;
        warnings.insert(warnings.end(), more.begin(), more.end());
    }
};

void print(const ConvertReport& report, std::size_t threads);
nlohmann::ordered_json to_json(const ConvertReport& report, std::size_t threads);

} // namespace isocast
