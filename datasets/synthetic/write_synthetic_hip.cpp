// Writes all meshes of the synthetic hip into one file, which becomes a part of the programs: write_synthetic_hip FILE
#include <cstdio>
#include <exception>
#include <fstream>

#include "datasets/synthetic/make_synthetic_hip.hpp"
#include "datasets/synthetic/mesh_pack.hpp"

int main(int count, char** arguments) {
  using namespace musclebench;
  if (count != 2) {
    std::fputs("write_synthetic_hip FILE\n", stderr);
    return 2;
  }
  try {
    std::ofstream out(arguments[1], std::ios::binary);
    for (const char* name : {"hip_bone", "femur", "adductor_brevis", "gluteus_maximus", "gluteus_medius", "iliacus"}) {
      append_to_pack(name, make_synthetic_hip_mesh(name), out);
    }
    out.close();
    return out ? 0 : 1;
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "write_synthetic_hip: %s\n", failure.what());
    return 1;
  }
}
