#include "backends/sdf/files/discregrid_file.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <utility>

#include <gtest/gtest.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/files/tests/stored_file_test.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

constexpr std::size_t header_bytes = 6 * 8 + 3 * 4 + 6 * 8 + 2 * 8;

class DiscregridFile : public StoredFileTest {
 protected:
  DiscregridFile() : StoredFileTest("bone.cdf") { write_discregrid(m_field, m_path); }

  static GridShape shape_of(const RepairedMesh& bone) {
    GridShape shape = grid_over(bone.mesh, {.cells = 6}, "box");
    shape.cells = {6, 5, 3};
    shape.cell_size_m = shape.cell_size_m.cwiseProduct(Vec3(1, 6.0 / 5, 2));
    return shape;
  }

  template <typename T>
  static void set(std::string& content, std::size_t at, T value) {
    std::memcpy(content.data() + at, &value, sizeof(value));
  }
  [[nodiscard]] std::string refusal() const {
    std::string line = refusal_by([&] { (void)read_discregrid(m_path, 1); });
    EXPECT_TRUE(line == "accepted" || line.find("leave out `discregrid`") != std::string::npos) << line;
    return line;
  }
  void expect_refusal(const std::string& words, const std::function<void(std::string&)>& edit) const {
    write_discregrid(m_field, m_path);
    change(edit);
    EXPECT_NE(refusal().find(words), std::string::npos) << refusal();
  }
  [[nodiscard]] std::size_t cells_at() const { return header_bytes + 16 + 8 * m_field.shape().node_count() + 16; }
  [[nodiscard]] std::size_t map_at() const { return cells_at() + 128 * m_field.shape().cell_count() + 16; }

  RepairedMesh m_bone{make_box({0.1, 0.06, 0.04}, 3), true, {}};
  CubicField m_field = build_field(SignedSurface(m_bone), shape_of(m_bone), 1);
};

TEST_F(DiscregridFile, HasTheSizeOfItsParts) {
  EXPECT_EQ(std::filesystem::file_size(m_path), map_at() + 4 * m_field.shape().cell_count());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(m_folder.path()), {}), 1) << "nothing else is left";
}

TEST_F(DiscregridFile, ComesBackAsItWas) {
  const CubicField read = read_discregrid(m_path, 1);
  EXPECT_EQ(read.shape().cells, m_field.shape().cells);
  EXPECT_EQ(read.shape().lower_m, m_field.shape().lower_m);
  EXPECT_EQ(read.shape().cell_size_m, m_field.shape().cell_size_m);
  EXPECT_EQ(read.mask(), m_field.mask());
  for (std::size_t cell = 0; cell < 1000; ++cell) {
    const Vec3 share(0.001 * static_cast<double>(cell), std::fmod(0.037 * static_cast<double>(cell), 1),
                     std::fmod(0.0173 * static_cast<double>(cell), 1));
    const Vec3 point = read.shape().lower_m + share.cwiseProduct(read.shape().upper_m() - read.shape().lower_m);
    EXPECT_EQ(read.value(point), m_field.value(point));
  }
}

TEST_F(DiscregridFile, NumbersNodesAsDiscregridDoes) {
  std::ifstream in(m_path, std::ios::binary);
  const std::string content((std::istreambuf_iterator<char>(in)), {});
  const auto [nx, ny, nz] = m_field.shape().cells;
  std::size_t at = header_bytes + 16;
  const auto expect_next = [&](double x, double y, double z) {
    double value = 0;
    std::memcpy(&value, content.data() + at, sizeof(value));
    at += sizeof(value);
    const Vec3 point = m_field.shape().lower_m + m_field.shape().cell_size_m.cwiseProduct(Vec3(x, y, z));
    const Vec3 inside = point.cwiseMin(m_field.shape().upper_m()).cwiseMax(m_field.shape().lower_m);
    ASSERT_NEAR(value, m_field.value(inside).value(), 1e-9) << x << ' ' << y << ' ' << z;
  };
  for (int vertex = 0; vertex < (nx + 1) * (ny + 1) * (nz + 1); ++vertex) {
    expect_next(vertex % (nx + 1), vertex / (nx + 1) % (ny + 1), vertex / ((nx + 1) * (ny + 1)));
  }
  for (int edge = 0; edge < nx * (ny + 1) * (nz + 1); ++edge) {
    for (const double third : {1. / 3, 2. / 3}) {
      expect_next(edge % nx + third, edge / nx % (ny + 1), edge / (nx * (ny + 1)));
    }
  }
  for (int edge = 0; edge < ny * (nz + 1) * (nx + 1); ++edge) {
    for (const double third : {1. / 3, 2. / 3}) {
      expect_next(edge / (ny * (nz + 1)), edge % ny + third, edge / ny % (nz + 1));
    }
  }
  for (int edge = 0; edge < nz * (nx + 1) * (ny + 1); ++edge) {
    for (const double third : {1. / 3, 2. / 3}) {
      expect_next(edge / nz % (nx + 1), edge / (nz * (nx + 1)), edge % nz + third);
    }
  }
}

TEST_F(DiscregridFile, FindsNodesThroughItsIndices) {
  // The last value moves to a new node, and every reference to the old one is moved to the new one.
  const std::size_t nodes = m_field.shape().node_count();
  change([&](std::string& content) {
    const std::size_t last = header_bytes + 16 + 8 * (nodes - 1);
    content.insert(last + 8, content.substr(last, 8));
    set(content, header_bytes + 8, static_cast<std::uint64_t>(nodes + 1));
    set(content, last, 1e300);
    for (std::size_t at = cells_at() + 8; at < map_at() + 8 - 16; at += 4) {
      std::uint32_t node = 0;
      std::memcpy(&node, content.data() + at, 4);
      if (node == nodes - 1) {
        set(content, at, static_cast<std::uint32_t>(nodes));
      }
    }
  });
  const CubicField read = read_discregrid(m_path, 1);
  EXPECT_EQ(read.values(), read_discregrid((write_discregrid(m_field, m_path), m_path), 1).values());
}

TEST_F(DiscregridFile, RefusesWhatIsNoWholeField) {
  expect_refusal("truncated", [](std::string& content) { content.pop_back(); });
  expect_refusal("truncated", [](std::string& content) { content.resize(40); });
  expect_refusal("truncated", [](std::string& content) { set(content, header_bytes + 8, std::uint64_t{1} << 60); });
  expect_refusal("goes on after its end", [](std::string& content) { content += '\0'; });
  expect_refusal("do not fit together", [](std::string& content) { set(content, 48, std::uint32_t{7}); });
  expect_refusal("do not fit together",
                 [](std::string& content) { std::reverse(content.begin(), content.begin() + 8); });
  expect_refusal("no Discregrid field", [](std::string& content) { content = std::string(2000, 'x'); });
  expect_refusal("holds no field", [](std::string& content) { set(content, header_bytes - 8, std::uint64_t{0}); });
  expect_refusal("lacks 1 of 90 cells", [&](std::string& content) { set(content, map_at() + 8, ~std::uint32_t{0}); });
  expect_refusal("cells that it does not hold", [&](std::string& content) { set(content, map_at(), 90U); });
  expect_refusal("has no value at a node", [&](std::string& content) { set(content, cells_at(), 1000000U); });
  expect_refusal("has no value at a node",
                 [](std::string& content) { set(content, header_bytes + 16, std::numeric_limits<double>::max()); });
  expect_refusal("is damaged: a node of cell 0 0 0 holds 1e+300 m",
                 [](std::string& content) { set(content, header_bytes + 16, 1e300); });
  expect_refusal("disagree about a node", [&](std::string& content) { set(content, cells_at() + 128, 0U); });
  std::filesystem::remove(m_path);
  EXPECT_NE(refusal().find("cannot be read"), std::string::npos);
}

TEST_F(DiscregridFile, NamesAnotherByteOrder) {
  expect_refusal("another byte order", [](std::string& content) {
    std::size_t at = 0;
    for (const auto& [numbers, bytes] : {std::pair(6, 8), std::pair(3, 4), std::pair(8, 8)}) {
      for (int number = 0; number < numbers; ++number, at += static_cast<std::size_t>(bytes)) {
        const auto first = content.begin() + static_cast<std::ptrdiff_t>(at);
        std::reverse(first, first + bytes);
      }
    }
  });
}

TEST_F(DiscregridFile, ThatCannotBeWrittenIsAnError) {
  write_discregrid(m_field, m_path);
  EXPECT_THROW(write_discregrid(m_field, m_path / "below a file"), InputError);
}

}  // namespace
}  // namespace musclebench
