#pragma once

#include <algorithm>
#include <cstddef>

namespace musclebench {

/// Calls `work(chunk, first, last)` for all chunks of `size` of the indices below `count`, dealt out to threads as they
/// become free. What a chunk finds goes into a place of its own, to be joined in order: the same for any number of
/// threads.
template <typename Work>
void for_each_chunk(std::size_t count, std::size_t size, [[maybe_unused]] int threads, const Work& work) {
  const std::size_t chunks = (count + size - 1) / size;
  const auto call = [&](std::size_t chunk) { work(chunk, chunk * size, std::min(count, (chunk + 1) * size)); };
  if (threads > 1 && chunks > 1) {  // OpenMP allocates even a team of one
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) call(chunk);
  } else {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) call(chunk);
  }
}

/// How many chunks `for_each_chunk` makes.
constexpr std::size_t chunk_count(std::size_t count, std::size_t size) { return (count + size - 1) / size; }

}  // namespace musclebench
