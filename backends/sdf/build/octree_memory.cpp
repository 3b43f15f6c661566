#include "backends/sdf/build/octree_memory.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "backends/sdf/build/octree_cells.hpp"
#include "core/base/input_error.hpp"
#include "core/base/system_memory.hpp"

namespace musclebench {

namespace {

double bytes_of(std::size_t cells) {
  return static_cast<double>(cells) * (sizeof(OctreeCell) + sizeof(OctreeCell::Leaf));
}

}  // namespace

OctreeMemory::OctreeMemory(std::string bone, double max_error_m, double aim_m, std::size_t bytes)
    : m_bone(std::move(bone)),
      m_max_error_m(max_error_m),
      m_aim_m(aim_m),
      m_available_bytes(static_cast<double>(bytes != 0 ? bytes : available_memory_bytes())) {}

/// Where kinks dominate the error the power is 2: an error half as large needs cells of half the edge along sheets.
/// Where a hundredth of the points are at kinks, and no more, the error falls with hardly a new cell.
void OctreeMemory::learn(std::size_t cells, double p99_m, bool exhausted) {
  const double bytes = bytes_of(cells);
  constexpr double least_fall = 1.05;
  if (m_last_p99_m > least_fall * p99_m && bytes > m_last_bytes) {
    m_growth_power = std::clamp(std::log(bytes / m_last_bytes) / std::log(m_last_p99_m / p99_m), 0.25, 2.0);
    ++m_learnt_from;
  }
  m_last_p99_m = p99_m;
  m_last_bytes = bytes;

  const double needed = bytes * growth_from(p99_m);
  if (exhausted) {
    refuse_bytes(needed, p99_m);
  }
  // Early on this overestimates: cells far from the surface are not divided any more.
  constexpr int enough_to_learn_from = 3;
  constexpr double doubt = 8;
  const double allowed = doubt * m_available_bytes;
  if (m_learnt_from >= enough_to_learn_from && needed > allowed) {
    refuse_bytes(needed, p99_m * std::min(1.0, std::pow(bytes / allowed, 1 / m_growth_power)));
  }
}

bool OctreeMemory::has_room_for(std::size_t cells) const { return bytes_of(cells) <= m_available_bytes; }

void OctreeMemory::refuse(std::size_t cells, double p99_m) const {
  refuse_bytes(bytes_of(cells) * growth_from(p99_m), p99_m);
}

void OctreeMemory::refuse_any_size(double p99_m) const { refuse_bytes(m_available_bytes, 2 * p99_m); }

/// Factor by which the number of cells grows until the target is reached.
double OctreeMemory::growth_from(double p99_m) const {
  return std::pow(std::max(1.0, p99_m / m_aim_m), m_growth_power);
}

void OctreeMemory::refuse_bytes(double needed, double fitting_aim_m) const {
  const double fitting_mm = fitting_aim_m * (m_max_error_m / m_aim_m) * 1e3;
  const double unit = std::pow(10, std::floor(std::log10(fitting_mm)) - 1);
  throw InputError(
      fmt::format("sdf: max_error_mm ({})", m_bone),
      fmt::format("{:.6g} needs about {:.0f} MB of memory, {:.0f} MB are there; {:.2g} fits", m_max_error_m * 1e3,
                  needed / 1e6, m_available_bytes / 1e6, std::ceil(fitting_mm / unit) * unit));
}

}  // namespace musclebench
