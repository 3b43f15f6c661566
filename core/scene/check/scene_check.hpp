#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/check/bone_nearness.hpp"
#include "core/scene/check/finding.hpp"
#include "core/scene/check/pose_estimates.hpp"

namespace musclebench {

/// The structure of a backend over one bone, as the backend tells once it is built.
struct BoneCells {
  std::string backend;
  double cell_m = 0;      ///< smallest edge of a cell; 0 without cells
  double error_m = 0;     ///< how far distances are off: measured where the backend does so (99 of 100), else a cell
  bool misses = false;    ///< contacts may be missed, too
  std::string parameter;  ///< that makes cells finer; empty: none
};

struct CheckOptions {
  bool only_quick = false;            ///< rules about effects: without geometry but for what surface_contact needs, too
  std::vector<BoneCells> cells = {};  ///< one a bone; empty: no backend was chosen
  std::function<void(int done, int total)> report = {};
};

/// What rules look at. What several of them need is measured at its first use.
class CheckContext {
 public:
  CheckContext(const Scene& checked, const CheckOptions& chosen) : scene(checked), options(chosen) {}

  const Scene& scene;
  const CheckOptions& options;

  [[nodiscard]] const PoseEstimates& poses();
  [[nodiscard]] const std::vector<BoneNearness>& nearness();  ///< by bone
  [[nodiscard]] const std::vector<double>& thickness_m();     ///< by node (node_thicknesses_m)
  /// That three quarters of the nodes exceed, m; nothing where no thickness can be told.
  [[nodiscard]] std::optional<double> usual_thickness_m();
  [[nodiscard]] std::size_t free_node_count();

 private:
  std::unique_ptr<PoseEstimates> m_poses;
  std::optional<std::vector<BoneNearness>> m_nearness;
  std::optional<std::vector<double>> m_thickness_m;
};

using Findings = std::vector<Finding>;

/// A rule: what it looks for, and a function that appends what it finds.
struct SceneRule {
  std::string id;
  std::function<void(CheckContext& context, Findings& findings)> look;
  bool needs_geometry = false;  ///< how bones and muscles lie and move: that takes a while
};

/// Rules about no effect of its own; each effect has others (EffectChecks).
const std::vector<SceneRule>& general_rules();

/// What the scene names and can't act, what contradicts itself, and what the scene calls for and lacks. All figures
/// come from geometry: nothing is simulated.
Findings check_scene(const Scene& scene, const CheckOptions& options = {});

/// What a run of the scene is warned of, and its result keeps: `scene_warnings` and what `check_scene` quickly finds.
std::vector<SceneWarning> warnings_of(const Scene& scene);

/// A muscle's surface, whose inside can be told.
bool is_closed_muscle(const Scene& scene, std::size_t muscle);

}  // namespace musclebench
