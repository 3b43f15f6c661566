#include "bench/results/result_folder.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <set>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

/// What `step` returns. Another run that made a folder takes it away again while it is empty, maybe between two looks
/// of this step, which is then tried again.
template <typename Step>
auto although_folders_vanish(const Step& step) {
  constexpr int most_tries = 1000;
  for (int tries = 1;; ++tries) {
    try {
      return step();
    } catch (const fs::filesystem_error& failure) {
      if (failure.code() != std::errc::no_such_file_or_directory || tries == most_tries) throw;
    }
  }
}

/// With the missing ones above it.
void create_folders(const fs::path& folder) {
  although_folders_vanish([&] { return fs::create_directories(folder); });
}

/// Makes the missing folders of a path, and removes those again that it made and that are still empty, unless told to
/// keep them.
class MissingFolders {
 public:
  explicit MissingFolders(const fs::path& folder) {
    for (fs::path path = folder; !fs::exists(path); path = path.parent_path()) {
      m_made.push_back(path);
    }
    create_folders(folder);
  }
  MissingFolders(const MissingFolders&) = delete;
  MissingFolders& operator=(const MissingFolders&) = delete;
  ~MissingFolders() {
    for (const fs::path& folder : m_made) {  // innermost first; another process may use the outer ones by now
      std::error_code ignored;
      fs::remove(folder, ignored);
    }
  }
  void keep() { m_made.clear(); }

 private:
  std::vector<fs::path> m_made;
};

/// A folder that goes with all that is in it, unless it was given another name before.
class PartFolder {
 public:
  explicit PartFolder(fs::path folder) : m_folder(std::move(folder)) { create_folders(m_folder); }
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;
  ~PartFolder() {
    std::error_code ignored;
    fs::remove_all(m_folder, ignored);
  }

 private:
  fs::path m_folder;
};

/// Absolute, without links and without a slash at its end.
fs::path resolved(const fs::path& folder) {
  const fs::path canonical = although_folders_vanish([&] { return fs::weakly_canonical(fs::absolute(folder)); });
  return canonical.has_filename() ? canonical : canonical.parent_path();
}

fs::path beside(const fs::path& folder, std::string_view ending) {
  return folder.parent_path() / fmt::format(".{}.{}.{}", folder.filename().string(), getpid(), ending);
}

bool is_text(const Json& manifest, const char* key) {
  return manifest.is_object() && manifest.contains(key) && manifest.at(key).is_string();
}

std::optional<std::int64_t> integer_at(const Json& json, const char* key) {
  if (!json.is_object() || !json.contains(key) || !json.at(key).is_number_integer()) return std::nullopt;
  return json.at(key).get<std::int64_t>();
}

/// Of a list; 0 for none.
std::int64_t length_at(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) && json.at(key).is_array()
             ? static_cast<std::int64_t>(json.at(key).size())
             : 0;
}

/// The rows of a table that end as lines do, and the first cell of the last of them.
struct WrittenRows {
  std::int64_t count = 0;
  std::string last;
};

WrittenRows rows_in(const fs::path& table) {
  std::ifstream file;
  std::error_code ignored;
  if (fs::is_regular_file(table, ignored)) {  // asked first: opening a pipe would wait for its writer
    file.open(table, std::ios::binary);
  }
  WrittenRows rows{-1, {}};  // the first line is the heading
  for (std::string line; std::getline(file, line) && !file.eof(); ++rows.count) {
    rows.last = line.substr(0, line.find(','));
  }
  return rows;
}

/// Rest and each frame, of each muscle and of each of its fibres.
bool has_all_fibres(const Json& manifest, const fs::path& folder) {
  if (!manifest.contains("fibres") || !manifest.at("fibres").is_array()) return true;
  const std::int64_t states = integer_at(manifest, "frames").value_or(0) + 1;
  std::int64_t fibres = 0;
  for (const Json& muscle : manifest.at("fibres")) fibres += integer_at(muscle, "followed").value_or(0);
  const auto muscles = static_cast<std::int64_t>(manifest.at("fibres").size());
  return rows_in(folder / "fibres.csv").count == states * muscles &&
         rows_in(folder / "fibre_lengths.csv").count == states * fibres;
}

bool has_all_forces(const Json& manifest, const fs::path& folder) {
  const auto rows = integer_at(manifest.value("forces", Json::object()), "rows");
  return !rows || rows_in(folder / "forces.csv").count == *rows;
}

/// Whether tables have the rows that run.json tells of: a full disk or a copy that was stopped may have cut it.
bool has_all_rows(const Json& manifest, const fs::path& table) {
  constexpr std::int64_t rows_of_a_probed_bone = 3;  // smooth, sharp and all
  if (manifest.contains("probed")) {
    return rows_in(table).count == rows_of_a_probed_bone * static_cast<std::int64_t>(manifest.at("probed").size());
  }
  const auto frames = integer_at(manifest, "frames");
  // A replay may leave frames of its recording out, but never the last.
  const bool is_replay = manifest.contains("recording");
  const auto last_frame = is_replay ? integer_at(manifest.at("recording"), "frames") : frames;
  const auto is_whole = [&](const fs::path& file, std::int64_t rows_of_a_frame) {
    const WrittenRows rows = rows_in(file);
    return rows.count == rows_of_a_frame * *frames && (*frames == 0 || rows.last == std::to_string(*last_frame));
  };
  const std::int64_t muscles = length_at(manifest, "muscles");
  const std::int64_t pairs = length_at(manifest.contains("case") ? manifest.at("case") : Json(), "muscle_contact") +
                             muscles * length_at(manifest, "bones");
  return frames && last_frame && is_whole(table, 1) &&
         (muscles == 0 || is_whole(table.parent_path() / "muscles.csv", muscles)) &&
         (pairs == 0 || is_whole(table.parent_path() / "pairs.csv", pairs)) &&
         has_all_fibres(manifest, table.parent_path()) && has_all_forces(manifest, table.parent_path());
}

/// A folder is replaced only when it is empty or holds a run and nothing else.
void require_replaceable(const fs::path& folder) {
  if (!fs::exists(folder)) {
    return;
  }
  if (!fs::is_directory(folder)) {
    throw InputError(folder.string(), "is a file; choose another --out");
  }
  const fs::path current = fs::current_path();
  if (current == folder || current.string().starts_with(folder.string() + "/")) {
    throw InputError(folder.string(), "holds the current folder and can't be replaced; choose another --out");
  }
  static const std::set<std::string> of_a_run = {
      "run.json",   "frames.csv", "muscles.csv",       "pairs.csv", "probe.csv", "snapshots",
      "fibres.csv", "forces.csv", "fibre_lengths.csv", "meshes",    "case.json", "resolved_scene.toml"};
  const bool foreign = std::any_of(fs::directory_iterator(folder), fs::directory_iterator(), [](const auto& entry) {
    return of_a_run.count(entry.path().filename().string()) == 0;
  });
  if (foreign || (!fs::is_empty(folder) && !is_text(read_manifest(folder), "run_id"))) {
    throw InputError(folder.string(), "holds something else than a run and would be replaced; choose another --out");
  }
}

}  // namespace

Json read_manifest(const fs::path& folder) {
  std::ifstream file;
  std::error_code ignored;
  if (fs::is_regular_file(folder / "run.json", ignored)) {  // asked first: opening a pipe would wait for its writer
    file.open(folder / "run.json");
  }
  return file.is_open() ? Json::parse(file, nullptr, false) : Json();
}

std::optional<StoredResult> complete_result(const fs::path& folder, const std::string& id, std::string_view rows_file) {
  const Json manifest = read_manifest(folder);
  if (!is_text(manifest, "run_id") || manifest.at("run_id") != id || !is_text(manifest, "status")) {
    return std::nullopt;
  }
  StoredResult result{manifest.at("status").get<std::string>(),
                      is_text(manifest, "status_detail") ? manifest.at("status_detail").get<std::string>() : ""};
  if ((result.status != "ok" && result.status != "suspect") || !has_all_rows(manifest, folder / rows_file)) {
    return std::nullopt;
  }
  return result;
}

bool is_complete(const fs::path& folder, const std::string& id, std::string_view rows_file) {
  return complete_result(folder, id, rows_file).has_value();
}

void require_writable(const fs::path& folder) {
  try {
    const fs::path target = resolved(folder);
    require_replaceable(target);
    const MissingFolders probe(beside(target, "part"));
  } catch (const fs::filesystem_error& failure) {
    throw InputError(folder.string(),
                     fmt::format("cannot be written ({}); choose another --out", failure.code().message()));
  }
}

void write_result_folder(const fs::path& folder, const std::function<void(const fs::path&)>& write_files) {
  try {
    const fs::path target = resolved(folder);
    MissingFolders parents(target.parent_path());
    const fs::path part = beside(target, "part");
    const PartFolder part_folder(part);
    write_files(part);
    require_replaceable(target);
    // The old result stays until the new one is in its place.
    const fs::path old = beside(target, "old");
    const bool replaces = fs::exists(target);
    if (replaces) {
      fs::rename(target, old);
    }
    std::error_code failure;
    fs::rename(part, target, failure);
    if (failure) {
      if (replaces) {
        fs::rename(old, target);
      }
      throw fs::filesystem_error("rename", part, target, failure);
    }
    fs::remove_all(old);
    parents.keep();
  } catch (const fs::filesystem_error& failure) {
    throw InputError(folder.string(), fmt::format("cannot be written ({})", failure.code().message()));
  }
}

}  // namespace musclebench
