// Distances beyond a band, by OpenVDB's fast sweeping.
// SPDX-License-Identifier: MPL-2.0
#include "volume/sweep.h"

#include "volume/errors.h"
#include "volume/vdb_grid.h"

#include <openvdb/tools/FastSweeping.h>
#include <tbb/parallel_for.h>

namespace isocast {

DenseField extend_by_sweeping(const SparseField& band, const IndexBox& box) {
    if (band.outside() != Outside::SignedBackground)
        throw InputError("a field without signs cannot be extended beyond its band");
    if (box.is_empty()) throw InputError("the box of the extended field is empty");
    openvdb::initialize();
    const openvdb::FloatGrid::Ptr grid = to_vdb_grid(band);
    openvdb::BoolGrid mask;
    mask.setTransform(grid->transform().copy());
    mask.denseFill({openvdb::Coord(box.lo.x(), box.lo.y(), box.lo.z()),
                    openvdb::Coord(box.hi.x() - 1, box.hi.y() - 1, box.hi.z() - 1)},
                   true);
    const openvdb::FloatGrid::Ptr full = openvdb::tools::maskSdf(*grid, mask);
    std::vector<float> values(static_cast<std::size_t>(box.sample_count()));
    const Index3 size = box.size();
    tbb::parallel_for(0, size.z(), [&](int z) {
        openvdb::FloatGrid::ConstAccessor at = full->getConstAccessor();
        std::size_t next = static_cast<std::size_t>(z) * size.x() * size.y();
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x)
                values[next++] = at.getValue({box.lo.x() + x, box.lo.y() + y, box.lo.z() + z});
    });
    return DenseField(band.space(), box, std::move(values));
}

} // namespace isocast
