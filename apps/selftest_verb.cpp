// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/console.h"
#include "apps/inputs.h"
#include "apps/parsed_option.h"
#include "apps/verdict_json.h"
#include "stability/cases.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include <cstdlib>
#include <fnmatch.h>

namespace isocast {

namespace {

struct SelftestCommand {
    bool stability = false;
    std::string only = "*";
    std::size_t threads =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    bool json = false;
};

struct Outcome {
    enum class Verdict { Ok, Fail, Skipped } verdict = Verdict::Ok;
    stability::Worst found;
    std::string reason; // of a skip, or what was thrown
};

const char* name_of(Outcome::Verdict verdict) {
    constexpr std::array names{"ok", "FAIL", "skipped"};
    return names[static_cast<std::size_t>(verdict)];
}

Outcome outcome_of(const stability::Case& a_case, stability::Devices& devices) {
    Outcome outcome;
    try {
        outcome.found = a_case.run(devices);
        if (!stability::passes(a_case, outcome.found)) outcome.verdict = Outcome::Verdict::Fail;
    } catch (const stability::Skip& skip) {
        outcome = {Outcome::Verdict::Skipped, {}, skip.what()};
    } catch (const Interrupted&) {
        throw;
    } catch (const std::exception& error) {
        outcome = {Outcome::Verdict::Fail, {}, error.what()};
    }
    return outcome;
}

void print(const stability::Case& a_case, const Outcome& outcome) {
    if (outcome.reason.empty())
        fmt::print("{:<44} {:>8} {:>9.2g} {:>9.2g}  {:<4}  {}\n", a_case.name,
                   outcome.found.checked, outcome.found.error, a_case.bound,
                   name_of(outcome.verdict), a_case.compares);
    else
        fmt::print("{:<44} {:>8} {:>9} {:>9.2g}  {}: {}\n", a_case.name, "-", "-", a_case.bound,
                   name_of(outcome.verdict), outcome.reason);
}

nlohmann::ordered_json to_json(const stability::Case& a_case, const Outcome& outcome) {
    nlohmann::ordered_json json = {{"case", a_case.name},
                                   {"compares", a_case.compares},
                                   {"checked", outcome.found.checked},
                                   {"error", outcome.found.error},
                                   {"bound", a_case.bound},
                                   {"bound_from", a_case.bound_from},
                                   {"verdict", name_of(outcome.verdict)}};
    // JSON has no infinity.
    if (!std::isfinite(outcome.found.error)) json["error"] = "infinite";
    if (!outcome.reason.empty()) json["reason"] = outcome.reason;
    return json;
}

void run(const SelftestCommand& command, Console& console,
         const std::vector<std::filesystem::path>& shader_folders) {
    if (!command.stability) throw UsageError("selftest: --stability is the check that there is");
    std::vector<stability::Case> cases = stability::all_cases();
    std::erase_if(cases, [&](const stability::Case& a_case) {
        return fnmatch(command.only.c_str(), a_case.name.c_str(), 0) != 0;
    });
    if (cases.empty())
        throw UsageError(fmt::format("--only {}: no case has such a name", command.only));
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, command.threads);
    // Those of software rasterisers, which read it when a context is made.
    setenv("LP_NUM_THREADS", std::to_string(command.threads).c_str(), 0);
    stability::Devices devices(first_folder_of(shader_folders));
    const Progress progress = console.progress();
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    std::array<int, 3> counts{};
    if (!command.json)
        fmt::print("{:<44} {:>8} {:>9} {:>9}\n", "case", "checked", "error", "bound");
    for (std::size_t i = 0; i < cases.size(); ++i) {
        progress(cases[i].name, double(i) / double(cases.size()));
        const Outcome outcome = outcome_of(cases[i], devices);
        ++counts[static_cast<std::size_t>(outcome.verdict)];
        console.end_progress();
        if (command.json)
            rows.push_back(to_json(cases[i], outcome));
        else
            print(cases[i], outcome);
    }
    const auto [ok, failed, skipped] = counts;
    if (command.json) {
        nlohmann::ordered_json drivers = nlohmann::ordered_json::array();
        for (const gl::DriverInfo& driver : devices.drivers())
            drivers.push_back({{"backend", driver.backend},
                               {"renderer", driver.renderer},
                               {"version", driver.version}});
        print_json({{"cases", rows},
                    {"ok", ok},
                    {"failed", failed},
                    {"skipped", skipped},
                    {"threads", command.threads},
                    {"drivers", drivers}});
    } else {
        fmt::print("{} cases: {} ok, {} failed, {} skipped\n", cases.size(), ok, failed, skipped);
        for (const gl::DriverInfo& driver : devices.drivers())
            fmt::print("{}: {}, {}\n", driver.backend, driver.renderer, driver.version);
    }
    if (failed > 0)
        throw std::runtime_error(fmt::format("{} of {} cases failed", failed, cases.size()));
}

} // namespace

Verb selftest_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders) {
    CLI::App* app = program.add_subcommand("selftest", "Check this installation on this machine");
    const auto command = std::make_shared<SelftestCommand>();
    app->add_flag("--stability", command->stability,
                  "The hard cases: error found and bound of each");
    app->add_option("--only", command->only, "Cases of such names alone, e.g. 'curvature.*'")
        ->type_name("PATTERN");
    add_threads(*app, command->threads);
    app->add_flag("--json", command->json, "Report as JSON");
    app->footer("Example: isocast selftest --stability --only 'view.*'");
    return {app, [command, folders = std::move(shader_folders)](Console& console) {
                run(*command, console, folders);
            }};
}

} // namespace isocast
