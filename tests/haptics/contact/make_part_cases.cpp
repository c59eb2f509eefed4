// make_part_cases OUT_DIR [NAME]: writes the hard cases of part contact, or those whose names begin with
// NAME, as OUT_DIR/CASE.glb and OUT_DIR/CASE.csv, and prints the command that runs each.

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/part_case_files.h"

namespace {

bool write(const std::filesystem::path& path, const char* data, std::size_t size) {
  std::ofstream file(path, std::ios::binary);
  file.write(data, static_cast<std::streamsize>(size));
  file.close();
  if (!file) std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
  return !file.fail();
}

}  // namespace

int main(int count, char** arguments) {
  using namespace tandem::test;
  const std::string first = count == 2 || count == 3 ? arguments[1] : "--";
  if (first.rfind("-", 0) == 0) {
    const bool asked = first == "--help" || first == "-h";
    std::fprintf(
        asked ? stdout : stderr,
        "usage: make_part_cases OUT_DIR [NAME]    writes the cases whose names begin with NAME there\n");
    return asked ? 0 : 2;
  }
  const std::filesystem::path folder = first;
  const std::string wanted = count == 3 ? arguments[2] : "";
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (const PartCase& given : allPartCases()) {
    if (given.name.rfind(wanted, 0) != 0) continue;
    const std::filesystem::path scene = folder / (given.name + ".glb"), path = folder / (given.name + ".csv");
    const std::vector<unsigned char> glb = glbOf(given);
    const std::string csv = csvOf(given);
    if (!write(scene, reinterpret_cast<const char*>(glb.data()), glb.size())) return 1;
    if (!write(path, csv.data(), csv.size())) return 1;
    std::printf("tandem probe %s --path %s --tool part:%s --stiffness 1000\n", scene.c_str(), path.c_str(),
                given.scene.parts[given.held].name.c_str());
  }
  return 0;
}
