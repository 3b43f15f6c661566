// What libFuzzer calls: a program over the readers that it is linked with. tools/fuzz runs it.
//   fuzz_readers --list                               the names of its readers, a line each
//   fuzz_readers --reader=NAME --write-seeds=DIR      the files to start from that only the program can write
//   fuzz_readers --reader=NAME [libFuzzer's options and folders]
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>

#include "core/fuzz/fuzzed_reader.hpp"

namespace musclebench {
namespace {

/// The value of the option `name`, which libFuzzer passes over for its two dashes and hands to the processes that it
/// starts itself.
std::optional<std::string> option(std::span<char*> arguments, const std::string& name) {
  const std::string begin = "--" + name + "=";
  for (const std::string_view argument : arguments) {
    if (argument.starts_with(begin)) return std::string(argument.substr(begin.size()));
  }
  return std::nullopt;
}

[[noreturn]] void end_with(const std::string& problem) {
  std::cerr << "fuzz_readers: " << problem << '\n';
  std::exit(2);
}

const FuzzedReader& reader_named(const std::string& name) {
  const auto readers = fuzzed_readers();
  const auto found = std::ranges::find(readers, name, &FuzzedReader::name);
  if (found == readers.end()) end_with("--reader=" + name + " names none of this program's readers");
  return *found;
}

/// libFuzzer's calls share nothing but this.
FuzzedReader& chosen_reader() {
  static FuzzedReader reader;
  return reader;
}

void write_seeds(const std::filesystem::path& folder) {
  if (chosen_reader().make_seeds == nullptr) return;
  int number = 0;
  for (const std::string& seed : chosen_reader().make_seeds()) {
    std::ofstream file(folder / ("seed_" + std::to_string(++number)), std::ios::binary);
    if (!(file << seed).flush()) end_with(folder.string() + ": cannot be written");
  }
}

}  // namespace
}  // namespace musclebench

extern "C" int LLVMFuzzerInitialize(int* count, char*** values) {  // NOLINT: libFuzzer's
  using namespace musclebench;
  const std::span<char*> arguments(*values, static_cast<std::size_t>(*count));
  if (std::ranges::find(arguments, std::string_view("--list"),
                        [](const char* word) { return std::string_view(word); }) != arguments.end()) {
    for (const FuzzedReader& reader : fuzzed_readers()) std::cout << reader.name << '\n';
    std::exit(0);
  }
  chosen_reader() = reader_named(option(arguments, "reader").value_or(""));
  if (const auto folder = option(arguments, "write-seeds")) {
    write_seeds(*folder);
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {  // NOLINT: libFuzzer's
  using namespace musclebench;
  (void)reads(chosen_reader(), {reinterpret_cast<const char*>(data), size});
  return 0;
}
