#include "core/referee/contact_comparison.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/percentile.hpp"

namespace musclebench {

ContactDifference compare_contacts(std::span<const Contact> answered, std::span<const Contact> truth) {
  const auto key = [](const Contact& contact) { return std::pair(contact.bone, contact.node); };
  ContactDifference difference;
  auto answer = answered.begin();
  auto real = truth.begin();
  while (answer != answered.end() && real != truth.end()) {
    if (key(*answer) == key(*real)) {
      ++answer;
      ++real;
    } else if (key(*answer) < key(*real)) {
      ++difference.false_contacts;
      ++answer;
    } else {
      ++difference.missed;
      ++real;
    }
  }
  difference.false_contacts += static_cast<int>(answered.end() - answer);
  difference.missed += static_cast<int>(truth.end() - real);
  return difference;
}

DepthStatistics depth_statistics(std::span<const Contact> truth) {
  if (truth.empty()) return {};
  std::vector<std::pair<int, double>> by_node;
  by_node.reserve(truth.size());
  for (const Contact& contact : truth) by_node.emplace_back(contact.node, contact.depth_m);
  std::sort(by_node.begin(), by_node.end());
  std::vector<double> depths;
  for (std::size_t i = 0; i < by_node.size(); ++i) {
    const bool deepest_of_node = i + 1 == by_node.size() || by_node[i + 1].first != by_node[i].first;
    if (deepest_of_node) depths.push_back(by_node[i].second);
  }
  std::sort(depths.begin(), depths.end());
  const double sum = std::accumulate(depths.begin(), depths.end(), 0.0);
  return {static_cast<int>(depths.size()), depths.back(), depths[percentile_index(depths.size(), 0.99)],
          sum / static_cast<double>(depths.size())};
}

}  // namespace musclebench
