#include "backends/sdf/bone_field.hpp"

#include "backends/sdf/field_contact.hpp"

namespace musclebench {

void BoneField::detect(const NodeBatch& batch, std::vector<Contact>& contacts) {
  const CellMap map(grid(), batch.pose);
  const auto wanted = batch.clearances != nullptr ? Wanted::clearances : Wanted::contacts;
  FieldAnswers answers;
  const FieldBlock& block = answers.block;
  for (std::size_t next = 0; next < batch.nodes.size();) {
    const std::size_t first = next;
    answers.block.count = 0;
    next = sample(map, batch.positions, batch.nodes, next, wanted, answers);
    for (std::size_t n = 0; n < block.count; ++n) {
      if (block.value_m[n] < 0) {
        contacts.push_back(field_contact(grid(), batch.pose, batch.bone, batch.nodes[block.query[n]], block, n));
      }
    }
    if (batch.clearances != nullptr) {
      store_sampled(batch, answers);
      store_left_out(batch, first, next, map, block);
    }
  }
  if (block.found_left_out) m_found_left_out.store(true, std::memory_order_relaxed);
}

void BoneField::store_sampled(const NodeBatch& batch, const FieldAnswers& answers) const {
  const FieldBlock& block = answers.block;
  FieldBlock::Lanes<double> clearance_m;
  find_clearances(answers, clearance_m);
  for (std::size_t n = 0; n < block.count; ++n) {
    if (block.value_m[n] >= 0) {
      batch.clearances->store(batch.bone, batch.nodes[block.query[n]], grid().point(block.cells(n)), clearance_m[n]);
    }
  }
}

/// Stores clearances of the nodes from `first` to `end` that are not in the block.
void BoneField::store_left_out(const NodeBatch& batch, std::size_t first, std::size_t end, const CellMap& map,
                               const FieldBlock& block) const {
  for (std::size_t index = first, n = 0; index < end; ++index) {
    if (n < block.count && block.query[n] == index) {
      ++n;
      continue;
    }
    const Vec3 cells = map.apply(batch.positions[static_cast<std::size_t>(batch.nodes[index])]);
    batch.clearances->store(batch.bone, batch.nodes[index], grid().point(cells), grid().distance_m(cells));
  }
}

}  // namespace musclebench
