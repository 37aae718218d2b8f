#pragma once
/// Certificates of both sides of a limit, as JSON and for ParaView.

#include <filesystem>
#include <nlohmann/json.hpp>

#include "limit/varied_scene.hpp"

namespace quoin::limit_analysis {

/// All that checks it: see tools/guides/limit.md.
nlohmann::ordered_json certificate(const Trial& trial, const Vary& vary);

/// Value and measures; null without a trial.
nlohmann::ordered_json summary(const Trial* trial);

/// What a contact does along the velocities.
enum class JointMotion : std::uint8_t { Closed, Slides, Opens };

/// PREFIX_blocks.vtk (blocks, displaced in `motion`: velocity, m/s) and PREFIX_contacts.vtk
/// (forces on the second block, N; JointMotion as a number). Throws FileError.
void write_vtk(const std::filesystem::path& blocks, const std::filesystem::path& contacts,
               const Trial& trial);

}  // namespace quoin::limit_analysis
