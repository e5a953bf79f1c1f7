// A run of `isocast accuracy`: all settings in turn, round by round, kept in a folder from which it
// goes on where it was interrupted.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/accuracy/study.h"

namespace isocast {

struct RunOptions {
    std::filesystem::path folder;
    std::vector<Sweep> sweeps; // the usual ones if empty
    int rounds = 3;
    bool is_fresh = false; // what the folder holds does not count
};

/// What ran: two runs may share a folder only if all of it is equal.
nlohmann::ordered_json description_of(const Study& study, const StudyOptions& options,
                                      const RunOptions& run, const gl::DriverInfo& driver);
/// The machine, for people.
nlohmann::ordered_json machine_json(const gl::DriverInfo& driver);

/// Measures what the folder does not hold yet: the errors once, then times in rounds over all
/// settings, so that a machine's drift is in all of them alike. Writes results.json now and then,
/// and both it and results.csv at the end, or when interrupted.
///
/// throws  Interrupted, after writing
std::vector<Measurement> measure(Study& study, const nlohmann::ordered_json& description,
                                 const nlohmann::ordered_json& machine, const RunOptions& options,
                                 const Progress& progress);

} // namespace isocast
