// SPDX-License-Identifier: MPL-2.0
#include "apps/gpu_scanner.h"

#include "apps/inputs.h"
#include "distance_transform/gl/scan_on_gpu.h"

namespace isocast {

BandScanner gpu_scanner(const std::vector<std::filesystem::path>& shader_folders) {
    return [shader_folders](const Sites& sites, const BandTiles& band, const WindingNumber* winding,
                            double voxel_size_world, std::int64_t& evaluations,
                            const Progress& progress) {
        const auto context = gl::make_context();
        gl::ShaderLibrary shaders({first_folder_of(shader_folders)});
        GpuScan scan =
            scan_on_gpu(*context, shaders, sites, band, winding, voxel_size_world, {}, progress);
        evaluations += scan.candidates;
        return std::move(scan.blocks);
    };
}

} // namespace isocast
