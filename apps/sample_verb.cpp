// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/console.h"
#include "apps/inputs.h"
#include "apps/parsed_option.h"
#include "apps/verdict_json.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/sparsify.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace isocast {

namespace {

struct SampleCommand {
    std::string name;
    std::filesystem::path output;
    bool list = false;
    bool json = false;
};

void list_names(bool json) {
    std::vector<std::string> names;
    for (const std::string& name : sample_mesh_names()) names.push_back("mesh:" + name);
    for (const std::string& name : builtin_field_names()) names.push_back("field:" + name);
    if (json)
        print_json({{"names", names}});
    else
        for (const std::string& name : names) fmt::print("{}\n", name);
}

void run(const SampleCommand& command, Console& console) {
    if (command.list) {
        list_names(command.json);
        return;
    }
    if (command.name.empty() || command.output.empty())
        throw UsageError("sample: NAME and -o FILE are needed, or --list");
    if (!command.name.starts_with("mesh:") && !command.name.starts_with("field:"))
        throw InputError(fmt::format("'{}' is no built-in name (isocast sample --list shows them)",
                                     command.name));
    const Input input = input_from(command.name);
    const Progress progress = console.progress();
    if (input.is_mesh()) {
        check_output(command.output, {".obj", ".ply", ".stl", ".off"});
        write_mesh(sample_mesh(input.name), command.output);
    } else {
        check_output(command.output, {".vdb"});
        write_vdb(to_sparse(*read_field(input), progress), command.output,
                  {{"creator", "isocast " ISOCAST_VERSION}, {"source", command.name}});
    }
    console.end_progress();
    if (command.json)
        print_json({{"name", command.name}, {"output", command.output.string()}});
    else
        fmt::print("{}: {}\n", command.output.string(), command.name);
}

} // namespace

Verb sample_verb(CLI::App& program) {
    CLI::App* app = program.add_subcommand("sample", "Write a built-in mesh or field to a file");
    const auto command = std::make_shared<SampleCommand>();
    app->add_option("NAME", command->name, "mesh:NAME, or field:NAME@N for N^3 samples (64)");
    app->add_option("-o,--output", command->output,
                    "File to write (meshes: .obj .ply .stl .off; fields: .vdb)")
        ->type_name("FILE");
    app->add_flag("--list", command->list, "Show the names");
    app->add_flag("--json", command->json, "Report as JSON");
    app->footer("Example: isocast sample field:gyroid@96 -o gyroid.vdb");
    return {app, [command](Console& console) { run(*command, console); }};
}

} // namespace isocast
