// SPDX-License-Identifier: MPL-2.0
#include "apps/inputs.h"

#include "distance_transform/mesh_files.h"
#include "distance_transform/sample_meshes.h"
#include "quadrics/molecule.h"
#include "quadrics/slim_file.h"
#include "volume/analytic_fields.h"
#include "volume/atomic_file.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace isocast {

namespace {

template<class Number>
Number parsed(std::string_view text, const char* kind) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
        throw UsageError(fmt::format("'{}' is not {}", text, kind));
    return value;
}

Input builtin_field_from(const std::string& text) {
    Input input{.kind = Input::Kind::BuiltinField, .text = text, .name = text.substr(6)};
    if (const auto at = input.name.find('@'); at != std::string::npos) {
        try {
            input.samples_per_axis = integer_from(input.name.substr(at + 1));
        } catch (const UsageError& error) {
            throw InputError(fmt::format("{}: samples per axis: {}", text, error.what()));
        }
        input.name.resize(at);
    }
    return input;
}

} // namespace

const char* Input::what() const {
    return is_mesh()    ? "a mesh"
           : is_field() ? "a field"
           : is_slim()  ? "a SLIM surface"
                        : "a molecule";
}

Input input_from(const std::string& text) {
    if (text.starts_with("mesh:"))
        return {.kind = Input::Kind::SampleMesh, .text = text, .name = text.substr(5)};
    if (text.starts_with("field:")) return builtin_field_from(text);

    Input input{.text = text, .name = text};
    // A colon is part of the file name if there is such a file.
    if (const auto colon = text.rfind(':'); colon != std::string::npos &&
                                            !std::filesystem::exists(text) &&
                                            is_field_file(text.substr(0, colon))) {
        input.name = text.substr(0, colon);
        input.grid = text.substr(colon + 1);
    }
    if (!std::filesystem::exists(input.name))
        throw InputError(fmt::format("{}: no such file", input.name));
    if (is_field_file(input.name))
        input.kind = Input::Kind::FieldFile;
    else if (is_molecule_file(input.name))
        input.kind = Input::Kind::MoleculeFile;
    else if (is_slim_file(input.name))
        input.kind = Input::Kind::SlimFile;
    else if (!is_mesh_file(input.name))
        throw InputError(fmt::format("{}: neither a field file ({}) nor a mesh file ({}) nor a "
                                     "molecule file ({}) nor a SLIM surface (.slim)",
                                     input.name, field_file_extensions(), mesh_file_extensions(),
                                     molecule_file_extensions()));
    return input;
}

CheckedMesh read_checked_mesh(const Input& input) {
    if (!input.is_mesh())
        throw InputError(fmt::format("{}: {}; a mesh is needed ({}, or mesh:NAME)", input.text,
                                     input.what(), mesh_file_extensions()));
    const Mesh mesh =
        input.kind == Input::Kind::MeshFile ? read_mesh(input.name) : sample_mesh(input.name);
    try {
        return check(mesh);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", input.text, error.what()));
    }
}

std::unique_ptr<FieldSource> read_field(const Input& input, double memory_bytes) {
    if (!input.is_field())
        throw InputError(fmt::format("{}: {}; a field is needed ({}, or field:NAME@N)", input.text,
                                     input.what(), field_file_extensions()));
    if (input.kind == Input::Kind::FieldFile)
        return read_field(input.name, input.grid, memory_bytes);
    return sampled(builtin_field(input.name), input.samples_per_axis);
}

void check_output(const std::filesystem::path& path, const std::vector<std::string>& extensions) {
    if (std::ranges::find(extensions, path.extension().string()) == extensions.end())
        throw UsageError(fmt::format("cannot write {}: the name must end in {}", path.string(),
                                     fmt::join(extensions, " or ")));
    const AtomicFile trial(path);
}

double number_from(std::string_view text) {
    const auto value = parsed<double>(text, "a number");
    if (!std::isfinite(value)) throw UsageError(fmt::format("'{}' is not a finite number", text));
    return value;
}

int integer_from(std::string_view text) {
    return parsed<int>(text, "an integer");
}

double bytes_from(std::string_view text) {
    double unit = 1;
    for (const auto& [letter, size] :
         {std::pair('K', 0x1p10), std::pair('M', 0x1p20), std::pair('G', 0x1p30)}) {
        if (!text.ends_with(letter)) continue;
        unit = size;
        text.remove_suffix(1);
        break;
    }
    const double count = number_from(text);
    if (!(count > 0)) throw UsageError(fmt::format("'{}' is not a size above 0", text));
    return count * unit;
}

std::filesystem::path config_folder() {
    const char* config = std::getenv("XDG_CONFIG_HOME");
    const char* home = std::getenv("HOME");
    const std::filesystem::path folder = config && *config ? std::filesystem::path(config)
                                         : home            ? std::filesystem::path(home) / ".config"
                                                           : std::filesystem::path();
    return folder.empty() ? folder : folder / "isocast";
}

std::filesystem::path first_folder_of(const std::vector<std::filesystem::path>& folders) {
    std::vector<std::string> names;
    for (const auto& folder : folders) {
        if (std::filesystem::is_directory(folder)) return folder;
        names.push_back(folder.string());
    }
    throw std::runtime_error(fmt::format("files of the program are missing: there is no folder {}",
                                         fmt::join(names, " and no ")));
}

} // namespace isocast
