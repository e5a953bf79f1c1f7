// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/console.h"
#include "apps/inputs.h"
#include "apps/parsed_option.h"
#include "apps/verdict_json.h"
#include "distance_transform/prism.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace isocast {

namespace {

using Json = nlohmann::ordered_json;

struct InfoCommand {
    std::string input;
    bool prisms = false;
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
                    {"value_range", {range.min, range.max}}});
        return;
    }
    fmt::print("{}: built-in field, {} samples {:.6g} apart, values in {} ... {}\n", command.input,
               text(extent.size()), space.voxel_size_world(), range.min, range.max);
}

Json to_json(const GridDescription& grid) {
    return {
        {"name", grid.name},
        {"class", grid.grid_class},
        {"type", grid.value_type},
        {"voxel_size", GridSpace{grid.world_from_index}.voxel_size_world()},
        {"world_from_index", to_json(grid.world_from_index)},
        {"background", grid.background_world},
        {"active_voxels", grid.active_voxels},
        {"active_box", {{"lo", to_json(grid.active_box.lo)}, {"hi", to_json(grid.active_box.hi)}}},
        {"metadata", grid.metadata}};
}

void print(const GridDescription& grid) {
    fmt::print("  '{}': {} of {}, voxel {:.6g}, background {:.6g}\n", grid.name, grid.grid_class,
               grid.value_type, GridSpace{grid.world_from_index}.voxel_size_world(),
               grid.background_world);
    fmt::print("    {} active voxels in the box {} ... {}\n", grid.active_voxels,
               text(grid.active_box.lo), text(Index3(grid.active_box.hi.array() - 1)));
    for (const auto& [key, value] : grid.metadata) fmt::print("    {}: {}\n", key, value);
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
    if (command.json) {
        Json described = Json::array();
        for (const GridDescription& grid : grids) described.push_back(to_json(grid));
        print_json({{"input", command.input}, {"kind", "field"}, {"grids", described}});
        return;
    }
    fmt::print("{}: {} grids\n", command.input, grids.size());
    for (const GridDescription& grid : grids) print(grid);
}

void run(const InfoCommand& command, Console& console) {
    const Input input = input_from(command.input);
    if (input.is_mesh())
        describe_mesh(command, read_checked_mesh(input), console);
    else if (input.kind == Input::Kind::BuiltinField)
        describe_field(command, *read_field(input));
    else
        describe_file(command, input);
}

} // namespace

Verb info_verb(CLI::App& program) {
    CLI::App* app = program.add_subcommand("info", "Say what a mesh or field holds");
    const auto command = std::make_shared<InfoCommand>();
    app->add_option("IN", command->input,
                    "Mesh (.obj .ply .stl .off, mesh:NAME) or field (.vdb, FILE.vdb:GRID, "
                    "field:NAME@N)")
        ->required();
    app->add_flag("--prisms", command->prisms,
                  "Of a mesh: count saddle vertices, and gaps between printed prisms (table 4.1)");
    app->add_flag("--json", command->json, "Report as JSON");
    app->footer("Example: isocast info bunny.vdb");
    return {app, [command](Console& console) { run(*command, console); }};
}

} // namespace isocast
