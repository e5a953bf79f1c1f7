// Tests of OpenVDB files: round trips bit for bit, what OpenVDB itself sees, foreign and bad files.
// SPDX-License-Identifier: MPL-2.0
#include "volume/files.h"

#include "random_fields.h"
#include "temporary_folder.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/sparsify.h"

#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Clip.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>

namespace isocast {
namespace {

namespace vdb = openvdb;
using test::Random;
using test::TemporaryFolder;

std::unique_ptr<SparseField> read_sparse(const std::filesystem::path& path,
                                         const std::string& grid_name = {}) {
    std::unique_ptr<FieldSource> field = read_field(path, grid_name);
    return std::unique_ptr<SparseField>(&dynamic_cast<SparseField&>(*field.release()));
}

void expect_same_blocks(const SparseField& a, const SparseField& b) {
    ASSERT_EQ(a.blocks().size(), b.blocks().size());
    for (std::size_t i = 0; i < a.blocks().size(); ++i) {
        EXPECT_EQ(a.blocks()[i].coordinate, b.blocks()[i].coordinate);
        EXPECT_EQ(a.blocks()[i].values, b.blocks()[i].values);
        EXPECT_EQ(a.blocks()[i].active, b.blocks()[i].active);
    }
}

/// Writes `grids` as another program would.
void write_grids(const std::filesystem::path& path, const vdb::GridCPtrVec& grids) {
    vdb::io::File(path.string()).write(grids);
}

vdb::FloatGrid::Ptr read_with_openvdb(const std::filesystem::path& path) {
    vdb::initialize();
    vdb::io::File file(path.string());
    file.open();
    EXPECT_EQ(file.getGrids()->size(), 1U);
    return vdb::gridPtrCast<vdb::FloatGrid>(file.readGrid("surface"));
}

vdb::Coord to_coord(const Index3& at) {
    return {at.x(), at.y(), at.z()};
}

// ------------------------------------------------------------------------------------ round trips

TEST(VdbFile, RoundTripKeepsEverySampleOfADistanceField) {
    const TemporaryFolder folder;
    for (const std::string name : {"sphere", "torus", "cylinder", "gyroid"}) {
        const SparseField field = to_sparse(*sampled(builtin_field(name), 150, 3));
        write_vdb(field, folder / "a.vdb");
        const auto read = read_sparse(folder / "a.vdb");
        expect_same_blocks(field, *read);
        EXPECT_EQ(read->outside(), Outside::SignedBackground);
        EXPECT_EQ(static_cast<float>(read->background_world()),
                  static_cast<float>(field.background_world()));
        const IndexBox around = dilated(field.extent(), 10, 10);
        EXPECT_EQ(test::copied(*read, around), test::copied(field, around));
    }
}

TEST(VdbFile, RoundTripKeepsSignsThatOnlyInactiveBlocksCarry) {
    // Open meshes change sign outside the band, in blocks that hold ± background alone. Blocks at
    // random have every such case: rows that end inside, begin inside, inner rows without blocks.
    const TemporaryFolder folder;
    Random random(1);
    for (int i = 0; i < 30; ++i) {
        for (const Outside outside : {Outside::SignedBackground, Outside::Background}) {
            const SparseField field(GridSpace::uniform(0.5), 1.5, outside,
                                    test::random_blocks(random, 3, i % 2 == 0 ? 0.05 : 0.4, 1.5f));
            write_vdb(field, folder / "a.vdb");
            const auto read = read_sparse(folder / "a.vdb");
            expect_same_blocks(field, *read);
            EXPECT_EQ(read->outside(), outside);
            const IndexBox around = dilated(field.extent(), 20, 20);
            EXPECT_EQ(test::copied(*read, around), test::copied(field, around));
        }
    }
}

TEST(VdbFile, RoundTripOfAnEmptyFieldIsEmpty) {
    const TemporaryFolder folder;
    write_vdb(SparseField(GridSpace::uniform(1), 3, Outside::SignedBackground, {}),
              folder / "a.vdb");
    EXPECT_TRUE(read_sparse(folder / "a.vdb")->blocks().empty());
}

TEST(VdbFile, RoundTripKeepsTransformsBitForBit) {
    const TemporaryFolder folder;
    std::vector<GridSpace> spaces{GridSpace::uniform(0.1, {0.1, -3.7, 1e6}), GridSpace::uniform(1)};
    GridSpace anisotropic = spaces[0];
    anisotropic.world_from_index.linear() = Vec3d(0.7, 0.7, 2.5).asDiagonal();
    spaces.push_back(anisotropic);
    GridSpace rotated = anisotropic;
    rotated.world_from_index.rotate(Eigen::AngleAxisd(0.6, Vec3d(1, 2, 3).normalized()));
    spaces.push_back(rotated);
    GridSpace mirrored;
    mirrored.world_from_index.linear() = Vec3d(-0.7, -0.7, 2.1).asDiagonal(); // as from DICOM
    mirrored.world_from_index.translation() = Vec3d(-0.1, 33.3, 1e5);
    spaces.push_back(mirrored);
    for (const GridSpace& space : spaces) {
        FieldBlock block;
        block.active.set();
        write_vdb(SparseField(space, 1, Outside::SignedBackground, {block}), folder / "a.vdb");
        EXPECT_EQ(read_field(folder / "a.vdb")->space().world_from_index.matrix(),
                  space.world_from_index.matrix());
        EXPECT_EQ(describe_field_file(folder / "a.vdb").at(0).world_from_index.matrix(),
                  space.world_from_index.matrix());
        // The point that OpenVDB itself makes of an index; its sums are in another order: ulps.
        const vdb::Vec3d p =
            read_with_openvdb(folder / "a.vdb")->indexToWorld(vdb::Vec3d(3, -5, 7));
        const Vec3d expected = space.to_world({3, -5, 7});
        EXPECT_LT((Vec3d(p.x(), p.y(), p.z()) - expected).norm(), 1e-15 * (1 + expected.norm()));
    }
}

TEST(VdbFile, DescriptionTellsWhatWasWritten) {
    const TemporaryFolder folder;
    const SparseField field = to_sparse(*sampled(builtin_field("torus"), 60, 3));
    write_vdb(field, folder / "a.vdb", {{"creator", "a test"}, {"sign_method", "normal"}});
    const std::vector<GridDescription> grids = describe_field_file(folder / "a.vdb");
    ASSERT_EQ(grids.size(), 1U);
    EXPECT_EQ(grids[0].name, "surface");
    EXPECT_EQ(grids[0].grid_class, "level set");
    EXPECT_EQ(grids[0].value_type, "float");
    EXPECT_EQ(grids[0].background_world, static_cast<float>(field.background_world()));
    EXPECT_EQ(grids[0].active_voxels, field.active_voxel_count());
    EXPECT_EQ(grids[0].metadata.at("creator"), "a test");
    EXPECT_EQ(grids[0].metadata.at("sign_method"), "normal");
    IndexBox active;
    test::for_each_sample(field.extent(), [&](const Index3& at) {
        if (std::abs(sample(field, at)) == static_cast<float>(field.background_world())) return;
        active = bounding_box(active, {at, (at.array() + 1).matrix()});
    });
    EXPECT_EQ(grids[0].active_box, active);
}

// ---------------------------------------------------------------------------- as OpenVDB sees them

TEST(VdbFile, IsALevelSetForOpenVdb) {
    const TemporaryFolder folder;
    const SparseField field = to_sparse(*sampled(builtin_field("sphere"), 150, 3));
    write_vdb(field, folder / "a.vdb");
    const vdb::FloatGrid::Ptr grid = read_with_openvdb(folder / "a.vdb");
    EXPECT_EQ(grid->getGridClass(), vdb::GRID_LEVEL_SET);
    EXPECT_EQ(grid->background(), static_cast<float>(field.background_world()));
    EXPECT_TRUE(grid->transform().isLinear());
    EXPECT_TRUE(grid->hasUniformVoxels());
    EXPECT_EQ(grid->activeVoxelCount(), static_cast<vdb::Index64>(field.active_voxel_count()));
    const auto accessor = grid->getConstAccessor();
    const IndexBox around = dilated(field.extent(), 10, 10);
    test::for_each_sample(around, [&](const Index3& at) {
        ASSERT_EQ(accessor.getValue(to_coord(at)), sample(field, at));
    });
    // The centre, far from the band, lies in a tile of the inside.
    const Index3 centre = (field.extent().lo + field.extent().hi) / 2;
    EXPECT_FALSE(accessor.probeConstLeaf(to_coord(centre)));
    EXPECT_EQ(accessor.getValue(to_coord(centre)), -grid->background());
}

TEST(VdbFile, IsSignedFloodFilledAndPruned) {
    const TemporaryFolder folder;
    // 300 samples: the inside holds whole tiles of 128^3 and chains of 8^3 ones.
    const SparseField field = to_sparse(*sampled(builtin_field("sphere"), 300, 3));
    write_vdb(field, folder / "a.vdb");
    const vdb::FloatGrid::Ptr grid = read_with_openvdb(folder / "a.vdb");
    const vdb::FloatGrid::Ptr filled = grid->deepCopy();
    vdb::tools::signedFloodFill(filled->tree());
    EXPECT_TRUE(filled->tree().hasSameTopology(grid->tree()));
    auto a = grid->tree().cbeginValueAll();
    auto b = filled->tree().cbeginValueAll();
    for (; a && b; ++a, ++b) ASSERT_EQ(*a, *b) << a.getCoord();
    EXPECT_FALSE(a);
    EXPECT_FALSE(b);
    EXPECT_EQ(grid->tree().leafCount(), field.blocks().size());
    // A node of tiles alone, all of one value, would be one tile.
    std::vector<const vdb::FloatTree::RootNodeType::ChildNodeType::ChildNodeType*> nodes;
    grid->tree().getNodes(nodes);
    for (const auto* node : nodes) {
        float value = 0;
        bool active = false;
        EXPECT_FALSE(node->isConstant(value, active, 0.0f));
    }
}

TEST(VdbFile, UnsignedFieldIsNoLevelSet) {
    const TemporaryFolder folder;
    Random random(2);
    const DenseField dense = test::random_dense(random, {{0, 0, 0}, {9, 9, 9}});
    write_vdb(to_sparse(dense), folder / "a.vdb");
    const vdb::FloatGrid::Ptr grid = read_with_openvdb(folder / "a.vdb");
    EXPECT_EQ(grid->getGridClass(), vdb::GRID_UNKNOWN);
    EXPECT_EQ(grid->activeVoxelCount(), 9U * 9U * 9U);
}

// ----------------------------------------------------------------------------------- foreign files

/// All samples of `read` in `box` are OpenVDB's.
template<class Grid>
void expect_samples_of(const Grid& grid, const FieldSource& read, const IndexBox& box) {
    const auto accessor = grid.getConstAccessor();
    test::for_each_sample(box, [&](const Index3& at) {
        ASSERT_EQ(sample(read, at), static_cast<float>(accessor.getValue(to_coord(at))))
            << at.transpose();
    });
}

TEST(VdbFile, ReadsALevelSetOfOpenVdb) {
    const TemporaryFolder folder;
    vdb::initialize();
    const auto grid =
        vdb::tools::createLevelSetSphere<vdb::FloatGrid>(20.0f, vdb::Vec3f(3, -4, 5), 0.5f, 3.0f);
    write_grids(folder / "a.vdb", {grid});
    const auto read = read_sparse(folder / "a.vdb");
    EXPECT_EQ(read->half_width_world(), 1.5);
    expect_samples_of(*grid, *read, dilated(read->extent(), 10, 10));
}

TEST(VdbFile, ReadsALevelSetWithItsSideCutOffWithinItsExtent) {
    const TemporaryFolder folder;
    vdb::initialize();
    const auto sphere =
        vdb::tools::createLevelSetSphere<vdb::FloatGrid>(20.0f, vdb::Vec3f(0, 0, 0), 0.5f, 3.0f);
    // Rows now begin inside, end inside, or lie inside with no leaf at all.
    const vdb::FloatGrid::Ptr grid =
        vdb::tools::clip(*sphere, vdb::BBoxd(vdb::Vec3d(-9, -30, -30), vdb::Vec3d(11, 8, 30)));
    grid->setGridClass(vdb::GRID_LEVEL_SET);
    grid->tree().voxelizeActiveTiles();
    write_grids(folder / "a.vdb", {grid});
    const auto read = read_sparse(folder / "a.vdb");
    expect_samples_of(*grid, *read, read->extent());
}

TEST(VdbFile, ReadsTilesDoublesAndHalves) {
    const TemporaryFolder folder;
    vdb::initialize();
    const auto grid = vdb::DoubleGrid::create(0.25);
    grid->setName("density");
    grid->fill(vdb::CoordBBox(vdb::Coord(0), vdb::Coord(15)), 0.75, true);
    grid->fill(vdb::CoordBBox(vdb::Coord(16), vdb::Coord(23)), -0.5, false); // inactive, not empty
    grid->tree().setValue(vdb::Coord(-3, 4, 5), 0.125);
    const auto half = vdb::FloatGrid::create(0.0f);
    half->setName("half");
    half->setSaveFloatAsHalf(true);
    half->tree().setValue(vdb::Coord(1, 2, 3), 0.5f);
    write_grids(folder / "a.vdb", {grid, half});
    const auto read = read_sparse(folder / "a.vdb");
    EXPECT_EQ(read->outside(), Outside::Background);
    expect_samples_of(*grid, *read, dilated(read->extent(), 10, 10));
    EXPECT_EQ(sample(*read_field(folder / "a.vdb", "half"), {1, 2, 3}), 0.5f);
    const std::vector<GridDescription> grids = describe_field_file(folder / "a.vdb");
    ASSERT_EQ(grids.size(), 2U);
    EXPECT_EQ(grids[0].value_type, "double");
    EXPECT_EQ(grids[0].background_world, 0.25);
    EXPECT_EQ(grids[1].value_type, "half");
}

TEST(VdbFile, ReadsTheMapsOfOpenVdb) {
    const TemporaryFolder folder;
    vdb::initialize();
    using vdb::math::Transform;
    const auto stretched = Transform::createLinearTransform(0.5);
    stretched->postScale(vdb::Vec3d(1, 2, 3));
    const auto turned = stretched->copy();
    turned->postRotate(0.7, vdb::math::Y_AXIS);
    turned->postTranslate(vdb::Vec3d(10, -20, 30));
    const auto sheared = turned->copy();
    sheared->postShear(0.3, vdb::math::X_AXIS, vdb::math::Y_AXIS);
    const auto before = Transform::createLinearTransform(0.5);
    before->preShear(-0.4, vdb::math::Z_AXIS, vdb::math::X_AXIS);
    before->preRotate(1.1, vdb::math::Z_AXIS);
    for (const Transform::Ptr& transform : {stretched, turned, sheared, before}) {
        for (const auto grid_class : {vdb::GRID_FOG_VOLUME, vdb::GRID_UNKNOWN}) {
            const auto grid = vdb::FloatGrid::create(0.0f);
            grid->setName("density");
            grid->setGridClass(grid_class);
            grid->setTransform(transform);
            grid->tree().setValue(vdb::Coord(1, 2, 3), 0.75f);
            write_grids(folder / "a.vdb", {grid});
            const auto read = read_field(folder / "a.vdb");
            const GridDescription description = describe_field_file(folder / "a.vdb").at(0);
            EXPECT_EQ(sample(*read, {1, 2, 3}), 0.75f);
            EXPECT_TRUE(description.is_affine);
            for (const vdb::Vec3d& at : {vdb::Vec3d(0, 0, 0), vdb::Vec3d(5, -3, 9)}) {
                const vdb::Vec3d p = grid->indexToWorld(at);
                const Vec3d expected(p.x(), p.y(), p.z());
                const Vec3d p_index(at.x(), at.y(), at.z());
                // The same sums in another order: ulps of 60.
                EXPECT_LT((read->space().to_world(p_index) - expected).norm(), 1e-13);
                EXPECT_LT((description.world_from_index * p_index - expected).norm(), 1e-13);
            }
        }
    }
}

// --------------------------------------------------------------------------------------- bad files

/// The message of the InputError on reading `path`, which describing it must throw as well.
std::string reading_error(const std::filesystem::path& path, const std::string& grid_name = {}) {
    return test::message_of<InputError>([&] { read_field(path, grid_name); });
}

void expect_parts(const std::string& message, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) {
        EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
    }
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(VdbFile, MissingFileFolderAndForeignContentsAreNamed) {
    const TemporaryFolder folder;
    expect_parts(reading_error(folder / "none.vdb"), {"none.vdb", "No such file"});
    std::filesystem::create_directory(folder / "folder.vdb");
    expect_parts(reading_error(folder / "folder.vdb"), {"folder.vdb", "is a folder"});
    std::ofstream(folder / "text.vdb") << "this is no volume at all, only text\n";
    expect_parts(reading_error(folder / "text.vdb"), {"text.vdb", "not an OpenVDB file"});
    std::ofstream(folder / "empty.vdb").flush();
    expect_parts(reading_error(folder / "empty.vdb"), {"empty.vdb", "not an OpenVDB file"});
    expect_parts(reading_error(folder / "a.tif"), {"a.tif", ".vdb"});
    expect_parts(test::message_of<InputError>([&] { describe_field_file(folder / "text.vdb"); }),
                 {"text.vdb", "not an OpenVDB file"});
}

TEST(VdbFile, TruncatedFileIsAnErrorAtEveryLength) {
    const TemporaryFolder folder;
    write_vdb(to_sparse(*sampled(builtin_field("sphere"), 24, 3)), folder / "a.vdb");
    const auto size = std::filesystem::file_size(folder / "a.vdb");
    ASSERT_GT(size, 1000U);
    for (std::uintmax_t length = 1; length < size; length += length < 1000 ? 1 : 997) {
        std::filesystem::copy_file(folder / "a.vdb", folder / "b.vdb",
                                   std::filesystem::copy_options::overwrite_existing);
        std::filesystem::resize_file(folder / "b.vdb", length);
        EXPECT_NE(reading_error(folder / "b.vdb"), "") << length << " of " << size;
        EXPECT_THROW(describe_field_file(folder / "b.vdb"), InputError) << length;
    }
    std::filesystem::resize_file(folder / "a.vdb", size - 1);
    expect_parts(reading_error(folder / "a.vdb"), {"a.vdb", "truncated"});
}

TEST(VdbFile, FilesWithoutTheFloatGridListTheirGrids) {
    const TemporaryFolder folder;
    vdb::initialize();
    const auto velocity = vdb::Vec3SGrid::create();
    velocity->setName("velocity");
    write_grids(folder / "a.vdb", {velocity});
    expect_parts(reading_error(folder / "a.vdb"), {"a.vdb", "no float grid", "velocity vec3s"});
    expect_parts(reading_error(folder / "a.vdb", "velocity"),
                 {"a.vdb", "'velocity'", "not a float grid", "velocity vec3s"});
    const auto density = vdb::FloatGrid::create();
    density->setName("density");
    write_grids(folder / "b.vdb", {velocity, density});
    EXPECT_EQ(reading_error(folder / "b.vdb"), ""); // takes the float grid
    expect_parts(reading_error(folder / "b.vdb", "surface"),
                 {"b.vdb", "'surface'", "density float, velocity vec3s"});
    write_grids(folder / "c.vdb", {});
    expect_parts(reading_error(folder / "c.vdb"), {"c.vdb", "no float grid", "none"});
}

TEST(VdbFile, FrustumsLevelSetsWithoutABandAndHugeTilesAreRefused) {
    const TemporaryFolder folder;
    vdb::initialize();
    const auto grid = vdb::FloatGrid::create(1.0f);
    grid->setName("fog");
    grid->setTransform(vdb::math::Transform::createFrustumTransform(
        vdb::BBoxd(vdb::Vec3d(0), vdb::Vec3d(10)), 0.5, 2.0, 0.1));
    write_grids(folder / "a.vdb", {grid});
    expect_parts(reading_error(folder / "a.vdb"), {"a.vdb", "'fog'", "frustum"});
    EXPECT_FALSE(describe_field_file(folder / "a.vdb").at(0).is_affine);
    const auto level_set = vdb::FloatGrid::create(0.0f);
    level_set->setGridClass(vdb::GRID_LEVEL_SET);
    write_grids(folder / "b.vdb", {level_set});
    expect_parts(reading_error(folder / "b.vdb"), {"b.vdb", "background"});
    const auto full = vdb::FloatGrid::create(0.0f);
    full->tree().addTile(3, vdb::Coord(0), 1.0f, true); // 4096^3 samples
    write_grids(folder / "c.vdb", {full});
    expect_parts(test::message_of<ResourceError>([&] { read_field(folder / "c.vdb"); }),
                 {"c.vdb", "tiles"});
}

TEST(VdbFile, WrittenToAStreamIsRefusedByName) {
    const TemporaryFolder folder;
    vdb::initialize();
    {
        std::ofstream file(folder / "a.vdb", std::ios::binary);
        vdb::io::Stream(file).write(vdb::GridCPtrVec{vdb::FloatGrid::create()});
    }
    expect_parts(reading_error(folder / "a.vdb"), {"a.vdb", "stream"});
}

TEST(VdbFile, FullDiskIsAResourceErrorAndLeavesNothing) {
    const TemporaryFolder folder;
    const SparseField field = to_sparse(*sampled(builtin_field("torus"), 60, 3));
    // A limit to the size of files stands for the full disk: both fail in the middle of a write.
    rlimit old_limit{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit = old_limit;
    limit.rlim_cur = 20000;
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    const std::string message =
        test::message_of<ResourceError>([&] { write_vdb(field, folder / "a.vdb"); });
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old_limit), 0);
    std::signal(SIGXFSZ, old_handler);
    expect_parts(message, {"a.vdb"});
    EXPECT_NE(message, "");
    EXPECT_EQ(folder.entry_count(), 0);
}

TEST(VdbFile, MissingFolderAndTinyVoxelsAreRefusedOnWriting) {
    const TemporaryFolder folder;
    const SparseField field(GridSpace::uniform(1e-9), 3e-9, Outside::SignedBackground, {});
    expect_parts(test::message_of<InputError>([&] { write_vdb(field, folder / "no/a.vdb"); }),
                 {"no", "does not exist"});
    // OpenVDB takes a determinant of 1e-27 for a singular transform.
    expect_parts(test::message_of<InputError>([&] { write_vdb(field, folder / "a.vdb"); }),
                 {"a.vdb", "transform"});
    EXPECT_EQ(folder.entry_count(), 0);
}

} // namespace
} // namespace isocast
