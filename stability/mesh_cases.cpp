// From meshes to distances: every sample against brute force, every side against the winding
// number summed over all triangles.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/brute_force.h"
#include "distance_transform/convert.h"
#include "distance_transform/gl/scan_on_gpu.h"
#include "distance_transform/sample_meshes.h"
#include "stability/cases.h"
#include "stability/fields.h"
#include "stability/hard_meshes.h"
#include "stability/shapes.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

namespace isocast::stability {

namespace {

/// What is wrong with the value of a sample [voxels]: distances off by more than half a unit in the
/// last place; infinite for a side, or for a sample that is in the band and not there.
class Judge {
public:
    Judge(const HardMesh& hard, const GridSpace& space, const Index3& origin)
        : hard_(hard), surface_(in_voxels(hard.mesh, space, origin)),
          solid_(in_voxels(hard.solid.triangles.empty() ? hard.mesh : hard.solid, space, origin)),
          voxel_(space.voxel_size_world()) {}

    double distance(const Vec3d& p) const { return brute_force_distance(surface_, p); }

    double error_of(float value, const Vec3d& p, double d) const {
        const float size = std::abs(value);
        const float next = std::nextafter(size, std::numeric_limits<float>::infinity());
        const double half_ulp = (double{next} - double{size}) / 2;
        const double error = (std::abs(size - d * voxel_) - half_ulp) / voxel_;
        // 1e-9: nearer to the surface the oracle's own rounding decides.
        if (hard_.sides == Sides::None || d < 1e-9) return error;
        const double w = brute_force_winding_number(solid_, p);
        // 0.1: what the hierarchy of open meshes' winding numbers may err by.
        if (hard_.sides == Sides::Open && std::abs(w - 0.5) < 0.1) return error;
        return std::signbit(value) == (w > 0.5) ? error : std::numeric_limits<double>::infinity();
    }

private:
    const HardMesh& hard_;
    Mesh surface_, solid_;
    double voxel_;
};

/// Calls error(index) for all samples of a box, on all threads.
template<class Error>
Worst over_samples(const IndexBox& box, const Error& error) {
    std::vector<Worst> rows(static_cast<std::size_t>(box.size().z()));
    tbb::parallel_for(0, box.size().z(), [&](int z) {
        for_each_sample({{box.lo.x(), box.lo.y(), box.lo.z() + z},
                         {box.hi.x(), box.hi.y(), box.lo.z() + z + 1}},
                        [&](const Index3& i) {
                            if (const auto e = error(i)) rows[static_cast<std::size_t>(z)].see(*e);
                        });
    });
    Worst worst;
    for (const Worst& row : rows) worst.see(row);
    return worst;
}

Worst judge_band(const HardMesh& hard, const SparseField& field, double half_width) {
    const IndexBox box = box_about(hard.mesh, field.space(), half_width);
    const Judge judge(hard, field.space(), box.lo);
    std::vector<float> values(static_cast<std::size_t>(box.sample_count()));
    field.copy_box(box, 0, values);
    std::vector<char> is_active(values.size());
    const Index3 n = box.size();
    const auto place = [&](const Index3& i) {
        const Index3 p = i - box.lo;
        return static_cast<std::size_t>(p.x()) +
               static_cast<std::size_t>(n.x()) *
                   (static_cast<std::size_t>(p.y()) +
                    static_cast<std::size_t>(n.y()) * static_cast<std::size_t>(p.z()));
    };
    Worst worst;
    for (const FieldBlock& block : field.blocks())
        for (int i = 0; i < samples_per_block; ++i) {
            if (!block.active[static_cast<std::size_t>(i)]) continue;
            const Index3 at = block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64);
            worst.must(box.contains(at));
            if (box.contains(at)) is_active[place(at)] = 1;
        }
    worst.see(over_samples(box, [&](const Index3& i) -> std::optional<double> {
        const Vec3d p = (i - box.lo).cast<double>();
        const double d = judge.distance(p);
        const float value = values[place(i)];
        if (is_active[place(i)])
            // 1e-6: by which the band may be too wide.
            return d > half_width + 1e-6 ? std::numeric_limits<double>::infinity()
                                         : judge.error_of(value, p, d);
        // 1e-10: rounding of the distances that brute force finds.
        if (d <= half_width - 1e-10) return std::numeric_limits<double>::infinity();
        if (hard.sides != Sides::Closed) return std::nullopt;
        // Background, of the right sign.
        return judge.error_of(std::copysign(float(d * field.space().voxel_size_world()), value), p,
                              d);
    }));
    return worst;
}

Worst converted(const HardMesh& hard, const ConvertOptions& asked = {}) {
    ConvertOptions options = asked;
    options.voxel_size_world = hard.voxel;
    const ConvertResult result = convert(check(hard.mesh), options);
    Worst worst = judge_band(hard, result.field, options.half_width_voxels);
    if (hard.sign_used) worst.must(result.sign_used == *hard.sign_used);
    return worst;
}

Worst converted_densely(const HardMesh& hard) {
    const DenseField field =
        convert_dense(check(hard.mesh), {.voxel_size_world = hard.voxel}).field;
    const Judge judge(hard, field.space(), field.extent().lo);
    return over_samples(field.extent(), [&](const Index3& i) -> std::optional<double> {
        const Vec3d p = (i - field.extent().lo).cast<double>();
        return judge.error_of(sample(field, i), p, judge.distance(p));
    });
}

/// Of the fields of the same mesh by two ways: differing bits [samples], infinite if blocks differ.
Worst same_bits(const SparseField& a, const SparseField& b) {
    Worst worst;
    worst.must(a.blocks().size() == b.blocks().size());
    if (worst.error > 0) return worst;
    double different = 0;
    for (std::size_t i = 0; i < a.blocks().size(); ++i) {
        worst.must(a.blocks()[i].coordinate == b.blocks()[i].coordinate &&
                   a.blocks()[i].active == b.blocks()[i].active);
        for (std::size_t k = 0; k < samples_per_block; ++k)
            different += a.blocks()[i].values[k] != b.blocks()[i].values[k];
    }
    worst.see(different);
    return worst;
}

SparseField field_of(const HardMesh& hard, ConvertOptions options = {}) {
    options.voxel_size_world = hard.voxel;
    return convert(check(hard.mesh), options).field;
}

Worst threads_do_not_matter(const HardMesh& hard) {
    const auto with = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return field_of(hard);
    };
    return same_bits(with(1), with(2));
}

Worst scanned_on_gpu(Device& device, const HardMesh& hard) {
    const BandScanner scanner = [&](const Sites& sites, const BandTiles& band,
                                    const WindingNumber* winding, double voxel,
                                    std::int64_t& evaluations, const Progress& progress) {
        GpuScan scan =
            scan_on_gpu(*device.context, device.shaders, sites, band, winding, voxel, {}, progress);
        evaluations += scan.candidates;
        return std::move(scan.blocks);
    };
    return same_bits(field_of(hard), field_of(hard, {.scanner = scanner}));
}

} // namespace

void append_mesh_cases(std::vector<Case>& cases) {
    constexpr double exact = 1e-5;
    const char* from = "what the project promises beside one rounding of the stored float";
    const char* compares = "all samples and sides and brute force in double [voxels]";
    for (const NamedMesh& named : hard_meshes())
        cases.push_back({std::string("mesh.") + named.name, compares, exact, from,
                         [make = named.make](Devices&) { return converted(make()); }});
    const auto add = [&](const char* name, const char* what, double bound, const char* why,
                         auto run) {
        cases.push_back(
            {std::string("mesh.") + name, what, bound, why, [run](Devices&) { return run(); }});
    };
    add("wide-band", compares, exact, from,
        [] { return converted(noisy(12), {.half_width_voxels = 9}); });
    add("winding-signs", compares, exact, from,
        [] { return converted(noisy(13), {.sign = SignMethod::Winding}); });
    add("towers-wedges-cones", "the same by CSC, the method that is compared with", exact, from,
        [] { return converted(noisy(14), {.method = BandMethod::Csc}); });
    add("dense-by-kd-tree", "the same of all samples of a box", exact, from,
        [] { return converted_densely(noisy(15)); });
    add("dense-at-offset-1e8", "the same far from the origin", exact, from,
        [] { return converted_densely(noisy(16, 1, Vec3d(1, -2, 1.5) * 1e8)); });
    add("threads-1-and-2", "fields of a spiky solid by 1 and 2 threads [differing samples]", 0,
        "bit for bit", [] { return threads_do_not_matter(noisy(17)); });
    add("threads-1-and-2-of-a-soup", "fields of flipped triangles by 1 and 2 threads [samples]", 0,
        "bit for bit", [] { return threads_do_not_matter(with_hole()); });
    append(cases, {"mesh.scan-of-a-spiky-solid", "fields by GPU and CPU [differing samples]", 1,
                   "one double in 2^29 rounds to another float",
                   [](Device& device) { return scanned_on_gpu(device, noisy(18)); }});
    append(cases, {"mesh.scan-at-offset-1e6", "fields by GPU and CPU [differing samples]", 1,
                   "one double in 2^29 rounds to another float", [](Device& device) {
                       return scanned_on_gpu(device, noisy(19, 1, Vec3d(1, -2, 1.5) * 1e6));
                   }});
    append(cases, {"mesh.scan-of-slivers", "fields by GPU and CPU [differing samples]", 1,
                   "one double in 2^29 rounds to another float", [](Device& device) {
                       return scanned_on_gpu(device, {with_slivers(noisy_sphere(1, 2), 1e-9)});
                   }});
}

} // namespace isocast::stability
