// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/calibrate.h"
#include "apps/accuracy/run.h"
#include "apps/console.h"
#include "apps/output_words.h"
#include "apps/parsed_option.h"
#include "apps/verbs.h"
#include "apps/verdict_json.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <tbb/global_control.h>

#include <array>

extern char** environ; // NOLINT: POSIX wants it declared by the program

namespace isocast {

namespace {

struct AccuracyCommand {
    StudyOptions study;
    std::vector<std::string> vary;
    PictureSize size{256, 256};
    RunOptions run;
    gl::Backend backend = gl::Backend::Auto;
    std::size_t threads =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    bool calibrate = false;
    bool json = false;
    std::vector<std::filesystem::path> data_folders;
};

/// Debian's own: another python on the path may lack matplotlib.
constexpr const char* python = "/usr/bin/python3";

/// throws  std::runtime_error unless it ended well
void write_report(const std::filesystem::path& script, const std::filesystem::path& folder) {
    std::array<std::string, 3> words{python, script.string(), folder.string()};
    const std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(),
                                         nullptr};
    pid_t child = 0;
    int status = -1;
    if (::posix_spawn(&child, python, nullptr, nullptr, arguments.data(), environ) == 0)
        ::waitpid(child, &status, 0);
    if (status != 0)
        throw std::runtime_error(
            fmt::format("no report: {} {} failed (Debian's python3-matplotlib draws it); "
                        "results.json and results.csv are in {}",
                        python, script.string(), folder.string()));
}

/// A folder of one's own, by what was measured.
std::filesystem::path usual_folder(const std::string& input) {
    std::string name = "accuracy-";
    for (const char c : std::filesystem::path(input).filename().string())
        name += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.' ? c : '-';
    return name;
}

void print_fronts(const std::vector<Measurement>& all) {
    for (const Stage& stage : stages()) {
        if (points_of(stage, all).size() < 2) continue;
        fmt::print("\n{}: {} [{}]; none is both cheaper and more accurate than\n", stage.name,
                   stage.what, stage.unit);
        for (const std::size_t i : front_of(stage, all)) {
            const Error& error = all[i].errors.at(std::string(stage.error));
            const auto [least, greatest] = spread_of(all[i], stage.price);
            fmt::print("  {:<44} rms {:<9.2g} max {:<9.2g} {:.3f} s ({:.3f} to {:.3f})\n",
                       text_of(all[i].setting), error.rms, error.max, price_of(all[i], stage.price),
                       least, greatest);
        }
    }
    for (const Measurement& measurement : all)
        if (!measurement.failed.empty())
            fmt::print("\nnot measured: {}: {}\n", text_of(measurement.setting),
                       measurement.failed);
}

void calibrate(const AccuracyCommand& command, Console& console) {
    if (own_front_path().empty())
        throw InputError("--calibrate: neither XDG_CONFIG_HOME nor HOME says where to keep it");
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      command.threads);
    const auto context = gl::make_context({.backend = command.backend});
    Renderer renderer(*context, first_folder_of(command.study.shader_folders));
    StudyOptions study = command.study;
    study.width = command.size.width;
    study.height = command.size.height;
    const Front front =
        calibrated(study, *context, renderer, command.run.rounds, console.progress());
    write_front(front, machine_json(context->driver()));
    console.end_progress();
    if (command.json)
        print_json({{"front", front.path.string()}});
    else
        fmt::print("{}: what `--max-error` will go by\n", front.path.string());
}

void run(AccuracyCommand command, Console& console) {
    if (command.calibrate) {
        if (!command.study.input.empty())
            throw UsageError("--calibrate measures built-in inputs, no other");
        return calibrate(command, console);
    }
    if (command.study.input.empty())
        throw UsageError("accuracy: an input is needed, or --calibrate");
    const Progress progress = console.progress();
    progress("reading", 0);
    const Subject subject = subject_of(input_from(command.study.input));
    Sweep varied;
    for (const std::string& text : command.vary) varied.push_back(values_from(text, subject));
    if (!varied.empty()) command.run.sweeps = {varied};
    if (command.run.folder.empty()) command.run.folder = usual_folder(command.study.input);
    std::filesystem::create_directories(command.run.folder);
    command.study.folder = command.run.folder;
    command.study.width = command.size.width;
    command.study.height = command.size.height;
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      command.threads);
    const auto context = gl::make_context({.backend = command.backend});
    Renderer renderer(*context, first_folder_of(command.study.shader_folders));
    Study study(command.study, *context, renderer, progress);
    if (command.run.sweeps.empty())
        command.run.sweeps =
            usual_sweeps(subject, study.input().samples_per_axis, study.brick_mib());
    const auto description = description_of(study, command.study, command.run, context->driver());
    const std::vector<Measurement> all = [&] {
        try {
            return measure(study, description, machine_json(context->driver()), command.run,
                           progress);
        } catch (const Interrupted&) {
            console.warn(fmt::format("what was measured is in {}; the same command goes on there",
                                     command.run.folder.string()));
            throw;
        }
    }();
    progress("drawing the report", 1);
    write_report(first_folder_of(command.data_folders) / "accuracy_report.py", command.run.folder);
    console.end_progress();
    if (command.json) {
        nlohmann::ordered_json out{{"folder", command.run.folder.string()},
                                   {"stages", stages_json(all)}};
        for (const Measurement& measurement : all) out["settings"].push_back(to_json(measurement));
        print_json(out);
    } else {
        fmt::print("{} settings, {} rounds; open {}\n", all.size(), command.run.rounds,
                   (command.run.folder / "report" / "index.html").string());
        print_fronts(all);
    }
}

} // namespace

Verb accuracy_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders,
                   std::vector<std::filesystem::path> data_folders) {
    CLI::App* app = program.add_subcommand(
        "accuracy", "Measure what accuracy costs in time: errors and times at many settings");
    const auto command = std::make_shared<AccuracyCommand>();
    command->study.shader_folders = std::move(shader_folders);
    command->data_folders = std::move(data_folders);
    app->add_option("IN", command->study.input,
                    "A mesh, a field, a molecule, or the built-in mesh:NAME, field:NAME@N");
    app->add_option("-o,--output", command->run.folder,
                    "Folder for results.json, results.csv and report/index.html; a run that was "
                    "interrupted goes on there (default: accuracy-IN)")
        ->type_name("DIR");
    app->add_option(
           "--vary", command->vary,
           "Instead of the usual knobs: KNOB=VALUE,VALUE,... or KNOB=LO:HI, which doubles; "
           "several are crossed")
        ->type_name("KNOB=LIST")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app->add_option("--set", command->study.settings,
                    "Set any key of a scene for all pictures (isocast render --keys)")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    add_parsed(*app, "--size", command->size, size_from,
               "Of the pictures, in pixels (default 256x256)")
        ->type_name("WxH");
    app->add_option("--repeats", command->run.rounds,
                    "Rounds over all settings; medians count (default 3)")
        ->check(CLI::Range(1, 1000))
        ->type_name("N");
    app->add_flag("--calibrate", command->calibrate,
                  "Measure instead what --max-error goes by, on this machine, and keep it in "
                  "XDG_CONFIG_HOME/isocast/front.json");
    app->add_flag("--fresh", command->run.is_fresh, "Do not go on with what the folder holds");
    add_parsed(*app, "--backend", command->backend, gl::backend_from_name,
               "OpenGL through: auto (egl, then osmesa), egl, osmesa")
        ->type_name("NAME");
    add_threads(*app, command->threads);
    app->add_flag("--json", command->json, "Report as JSON");
    app->footer("Example: isocast accuracy field:torus@64 --vary filter=linear,interpolating");
    return {app, [command](Console& console) { run(*command, console); }};
}

} // namespace isocast
