// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/console.h"
#include "apps/inputs.h"
#include "apps/parsed_option.h"
#include "apps/slim_output.h"
#include "apps/verdict_json.h"
#include "apps/volume_report.h"
#include "distance_transform/prism.h"
#include "quadrics/molecule.h"
#include "quadrics/slim_file.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace isocast {

namespace {

using Json = nlohmann::ordered_json;

struct InfoCommand {
    std::string input;
    bool prisms = false;
    std::optional<double> memory_bytes;
    bool json = false;
};

template<class Vector>
Json to_json(const Vector& v) {
    return {v.x(), v.y(), v.z()};
}

template<class Vector>
std::string text(const Vector& v) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", double(v.x()), double(v.y()), double(v.z()));
}

Json to_json(const Eigen::Affine3d& map) {
    Json rows = Json::array();
    for (int i = 0; i < 4; ++i) rows.push_back({map(i, 0), map(i, 1), map(i, 2), map(i, 3)});
    return rows;
}

void describe_mesh(const InfoCommand& command, const CheckedMesh& checked, Console& console) {
    const MeshVerdict& verdict = checked.verdict;
    const WorldBox box = bounding_box(checked.mesh);
    for (const std::string& warning : checked.warnings)
        console.warn(fmt::format("{}: {}", command.input, warning));
    std::optional<CoveringCounts> covering;
    if (command.prisms) covering = Prisms(checked.mesh, 1, Gaps::Leave).counts();
    if (command.json) {
        Json json = {{"input", command.input},
                     {"kind", "mesh"},
                     {"vertices", verdict.vertices},
                     {"triangles", verdict.triangles},
                     {"box", {{"min", to_json(box.min)}, {"max", to_json(box.max)}}},
                     {"verdict", to_json(verdict)},
                     {"warnings", checked.warnings}};
        if (covering)
            json["prisms"] = {{"vertices", covering->vertices},
                              {"saddles", covering->saddles},
                              {"gaps", covering->gaps}};
        print_json(json);
        return;
    }
    fmt::print("{}: mesh of {} vertices, {} triangles: {}\n", command.input, verdict.vertices,
               verdict.triangles, verdict.summary());
    fmt::print("  box {} ... {}\n", text(box.min), text(box.max));
    fmt::print("  {} shells, volume {:.6g}\n", verdict.shells, verdict.volume_world);
    if (covering)
        fmt::print("  printed prisms: {} vertices, {} saddles, {} with a gap\n", covering->vertices,
                   covering->saddles, covering->gaps);
}

void describe_field(const InfoCommand& command, const FieldSource& field) {
    const IndexBox extent = field.extent();
    const GridSpace& space = field.space();
    const ValueRange range = field.value_range(extent);
    if (command.json) {
        print_json({{"input", command.input},
                    {"kind", "built-in field"},
                    {"voxel_size", space.voxel_size_world()},
                    {"world_from_index", to_json(space.world_from_index)},
                    {"samples", to_json(extent.size())},
                    {"value_range", {range.min, range.max}},
                    {"suggested_iso", 0}});
        return;
    }
    fmt::print("{}: built-in field, {} samples {:.6g} apart, values in {} ... {}\n", command.input,
               text(extent.size()), space.voxel_size_world(), range.min, range.max);
}

/// The box in the world of the centres of the samples in `box`.
WorldBox world_box(const Eigen::Affine3d& world_from_index, const IndexBox& box) {
    WorldBox world;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3d p_index = box.lo.cast<double>();
        for (int axis = 0; axis < 3; ++axis)
            if (corner >> axis & 1) p_index[axis] = box.hi[axis] - 1;
        const Vec3d p_world = world_from_index * p_index;
        world.min = corner == 0 ? p_world : Vec3d(world.min.cwiseMin(p_world));
        world.max = corner == 0 ? p_world : Vec3d(world.max.cwiseMax(p_world));
    }
    return world;
}

/// What is said of a grid's values, or why nothing is.
struct GridValues {
    std::optional<FieldStatistics> statistics;
    std::optional<double> suggested_iso;
    std::string unknown_because;
};

/// Dense files and sparse densities are looked at. Level sets need not be read.
/// throws  InputError if a dense file has a sample that is no number
GridValues values_of(const GridDescription& grid, const Input& input, double memory_bytes) {
    const bool is_dense = grid.grid_class == "dense";
    if (!grid.is_affine) return {.unknown_because = "its transform is a frustum"};
    if (grid.grid_class == "level set") return {.suggested_iso = 0};
    // 2^28 samples of a .vdb file are 1.2 GB when they are loaded.
    if (!is_dense && grid.active_voxels > std::int64_t{1} << 28)
        return {.unknown_because = "too many samples to load"};
    try {
        const auto field = read_field(input.name, is_dense ? input.grid : grid.name, memory_bytes);
        GridValues values{.statistics = statistics_of(*field)};
        values.suggested_iso = values.statistics->suggested.iso;
        return values;
    } catch (const InputError& error) {
        if (is_dense) throw;
        return {.unknown_because = error.what()}; // no scalar grid, but one to describe
    } catch (const ResourceError& error) {
        return {.unknown_because = error.what()};
    }
}

Json to_json(const GridDescription& grid, const GridValues& values) {
    const Vec3d spacing = grid.world_from_index.linear().colwise().norm();
    const WorldBox world = world_box(grid.world_from_index, grid.active_box);
    Json json = {
        {"name", grid.name},
        {"class", grid.grid_class},
        {"type", grid.value_type},
        {"voxel_size", GridSpace{grid.world_from_index}.voxel_size_world()},
        {"spacing", to_json(spacing)},
        {"world_from_index", to_json(grid.world_from_index)},
        {"is_affine", grid.is_affine},
        {"background", grid.background_world},
        {"active_voxels", grid.active_voxels},
        {"active_box", {{"lo", to_json(grid.active_box.lo)}, {"hi", to_json(grid.active_box.hi)}}},
        {"size", to_json(grid.active_box.size())},
        {"metadata", grid.metadata}};
    if (grid.is_affine && !grid.active_box.is_empty())
        json["world_box"] = {{"min", to_json(world.min)}, {"max", to_json(world.max)}};
    if (values.statistics)
        add_statistics(json, *values.statistics);
    else if (values.suggested_iso)
        json["suggested_iso"] = *values.suggested_iso;
    else
        json["values_unknown_because"] = values.unknown_because;
    return json;
}

void print(const GridDescription& grid, const GridValues& values) {
    const Vec3d spacing = grid.world_from_index.linear().colwise().norm();
    if (grid.grid_class == "dense") {
        fmt::print("  {} samples of {}, {} apart\n", text(grid.active_box.size()), grid.value_type,
                   text(spacing));
    } else {
        fmt::print("  '{}': {} of {}, voxel {}, background {:.6g}\n", grid.name, grid.grid_class,
                   grid.value_type, text(spacing), grid.background_world);
        fmt::print("    {} active voxels in the box {} ... {}\n", grid.active_voxels,
                   text(grid.active_box.lo), text(Index3(grid.active_box.hi.array() - 1)));
    }
    if (grid.is_affine && !grid.active_box.is_empty()) {
        const WorldBox world = world_box(grid.world_from_index, grid.active_box);
        fmt::print("    in the world {} ... {}\n", text(world.min), text(world.max));
    }
    for (const auto& [key, value] : grid.metadata) fmt::print("    {}: {}\n", key, value);
    if (values.statistics)
        print_statistics(*values.statistics);
    else if (values.suggested_iso)
        fmt::print("    suggested iso {:.6g}\n", *values.suggested_iso);
    else
        fmt::print("    values not looked at: {}\n", values.unknown_because);
}

void describe_file(const InfoCommand& command, const Input& input) {
    std::vector<GridDescription> grids = describe_field_file(input.name);
    if (!input.grid.empty()) {
        std::vector<std::string> names;
        for (const GridDescription& grid : grids) names.push_back(grid.name);
        std::erase_if(grids, [&](const GridDescription& grid) { return grid.name != input.grid; });
        if (grids.empty())
            throw InputError(fmt::format("{}: no grid '{}' (has: {})", input.name, input.grid,
                                         fmt::join(names, ", ")));
    }
    std::vector<GridValues> values;
    for (const GridDescription& grid : grids)
        values.push_back(
            values_of(grid, input, command.memory_bytes.value_or(default_field_bytes())));
    if (command.json) {
        Json described = Json::array();
        for (std::size_t i = 0; i < grids.size(); ++i)
            described.push_back(to_json(grids[i], values[i]));
        print_json({{"input", command.input}, {"kind", "field"}, {"grids", described}});
        return;
    }
    if (grids.size() == 1 && grids[0].grid_class == "dense")
        fmt::print("{}: a volume\n", command.input);
    else
        fmt::print("{}: {} grids\n", command.input, grids.size());
    for (std::size_t i = 0; i < grids.size(); ++i) print(grids[i], values[i]);
}

void describe_molecule(const InfoCommand& command, const Molecule& molecule) {
    std::vector<std::string> chains; // in the order of their first atoms
    Eigen::AlignedBox3d box;
    std::size_t waters = 0;
    for (const Atom& atom : molecule.atoms) {
        if (std::ranges::find(chains, atom.chain) == chains.end()) chains.push_back(atom.chain);
        box.extend(atom.position);
        waters += atom.is_water ? 1 : 0;
    }
    if (command.json) {
        print_json({{"input", command.input},
                    {"kind", "molecule"},
                    {"title", molecule.title},
                    {"atoms", molecule.atoms.size()},
                    {"of_waters", waters},
                    {"bonds", molecule.bonds.size()},
                    {"chains", chains},
                    {"box_angstrom",
                     {{box.min().x(), box.min().y(), box.min().z()},
                      {box.max().x(), box.max().y(), box.max().z()}}}});
        return;
    }
    fmt::print("{}: a molecule\n", command.input);
    if (!molecule.title.empty()) fmt::print("  {}\n", molecule.title);
    fmt::print("  {} atoms, {} of them of waters; {} bonds; model {}\n", molecule.atoms.size(),
               waters, molecule.bonds.size(), molecule.atoms.front().model);
    fmt::print("  chains {}\n", fmt::join(chains, ", "));
    const Vec3d size = box.sizes();
    fmt::print("  {:.1f} x {:.1f} x {:.1f} angstrom\n", size.x(), size.y(), size.z());
}

void run(const InfoCommand& command, Console& console) {
    const Input input = input_from(command.input);
    if (input.is_slim())
        describe_slim(command.input, command.json);
    else if (input.is_mesh())
        describe_mesh(command, read_checked_mesh(input), console);
    else if (input.kind == Input::Kind::BuiltinField)
        describe_field(command, *read_field(input));
    else if (input.kind == Input::Kind::MoleculeFile)
        describe_molecule(command, read_molecule(input.name, {.waters = true}));
    else
        describe_file(command, input);
}

} // namespace

Verb info_verb(CLI::App& program) {
    CLI::App* app = program.add_subcommand("info", "Say what a mesh, field or volume holds");
    const auto command = std::make_shared<InfoCommand>();
    app->add_option("IN", command->input,
                    "Mesh (.obj .ply .stl .off, mesh:NAME), molecule (.pdb .ent .cif .mmcif .xyz), "
                    "field (.vdb, FILE.vdb:GRID, "
                    "field:NAME@N), volume (.nrrd .nhdr .mhd .mha .nii .nii.gz) or .slim")
        ->required();
    app->add_flag("--prisms", command->prisms,
                  "Of a mesh: count saddle vertices, and gaps between printed prisms (table 4.1)");
    add_field_memory(*app, command->memory_bytes);
    app->add_flag("--json", command->json, "Report as JSON");
    app->footer("Example: isocast info bunny.vdb");
    return {app, [command](Console& console) { run(*command, console); }};
}

} // namespace isocast
