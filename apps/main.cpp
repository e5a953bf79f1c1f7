// The program: parses the command line, runs one verb, turns failures into exit codes.
// SPDX-License-Identifier: MPL-2.0
#include "apps/console.h"
#include "apps/inputs.h"
#include "apps/verbs.h"
#include "gl/errors.h"
#include "volume/errors.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>

namespace isocast {

namespace {

enum ExitCode {
    Ok = 0,
    Failed = 1,
    Usage = 2,
    BadInput = 3,
    OverLimit = 4,
    NoGl = 5,
    WasInterrupted = 130, // 128 + SIGINT, as shells have it
};

constexpr const char* exit_codes =
    "Exit codes: 0 ok, 1 failed, 2 usage, 3 bad input, 4 over a memory limit, 5 no usable OpenGL, "
    "130 interrupted";

/// Beside the program in a build folder, and where `cmake --install` puts them.
std::vector<std::filesystem::path> shader_folders() {
    const auto bin = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    return {bin / "shaders", bin.parent_path() / "share/isocast/shaders"};
}

/// Likewise, of what is neither program nor shader.
std::vector<std::filesystem::path> data_folders() {
    const auto bin = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    return {bin / "data", bin.parent_path() / "share/isocast/data"};
}

int run(int argc, char** argv, Console& console) {
    CLI::App program("Meshes to distance fields, distance fields to pictures.", "isocast");
    program.set_version_flag("--version", "isocast " ISOCAST_VERSION);
    program.footer(fmt::format("{}\nExample: isocast render mesh:knot -o knot.png", exit_codes));
    program.fallthrough();
    program.require_subcommand(0, 1);
    const std::array verbs{convert_verb(program, shader_folders(), data_folders()),
                           render_verb(program, shader_folders(), data_folders()),
                           view_verb(program, shader_folders(), data_folders()),
                           info_verb(program),
                           accuracy_verb(program, shader_folders(), data_folders()),
                           sample_verb(program),
                           selftest_verb(program, shader_folders())};
    for (const Verb& verb : verbs)
        verb.app->footer(fmt::format("{}\n{}", exit_codes, verb.app->get_footer()));
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        // Help and version arrive as errors with code 0.
        if (error.get_exit_code() == 0) return program.exit(error);
        throw UsageError(error.what());
    }
    for (const Verb& verb : verbs)
        if (verb.app->parsed()) {
            verb.run(console);
            return Ok;
        }
    throw UsageError("a verb is needed: convert, render, view, info, accuracy, sample or selftest");
}

int run_and_report(int argc, char** argv, Console& console) {
    const auto failed = [&](ExitCode code, const char* why) {
        console.error(why);
        return code;
    };
    try {
        return run(argc, argv, console);
    } catch (const Interrupted& error) {
        return failed(WasInterrupted, error.what());
    } catch (const UsageError& error) {
        return failed(Usage, fmt::format("{} (isocast --help shows how)", error.what()).c_str());
    } catch (const InputError& error) {
        return failed(BadInput, error.what());
    } catch (const ResourceError& error) {
        return failed(OverLimit, error.what());
    } catch (const std::bad_alloc&) {
        return failed(OverLimit, "not enough memory");
    } catch (const gl::NoContextError& error) {
        return failed(NoGl, error.what());
    } catch (const std::exception& error) {
        return failed(Failed, error.what());
    }
}

} // namespace

} // namespace isocast

int main(int argc, char** argv) {
    isocast::Console console;
    const int code = isocast::run_and_report(argc, argv, console);
    // Output that did not arrive is a failure.
    if (std::fflush(stdout) != 0) {
        console.error(fmt::format("cannot write the report: {}", std::strerror(errno)));
        return isocast::Failed;
    }
    return code;
}
