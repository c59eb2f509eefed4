#include <cstdio>
#include <fstream>
#include <string>

#include "assets/generate/sample_scene.h"

/// tandem-scenes OUTDIR: writes the sample scenes.
int main(int argc, char** argv) {
  const std::string folder = argc == 2 ? argv[1] : "--";
  if (folder.rfind("-", 0) == 0) {
    const bool wantsHelp = folder == "--help" || folder == "-h";
    std::fprintf(wantsHelp ? stdout : stderr,
                 "usage: tandem-scenes OUTDIR    writes the sample scenes there\n");
    return wantsHelp ? 0 : 2;
  }
  for (const tandem::generate::SampleScene& scene : tandem::generate::makeAllScenes()) {
    const std::string path = folder + "/" + scene.name + ".glb";
    const std::string bytes = tandem::generate::toGlb(scene);
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) {
      std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
      return 1;
    }
    std::printf("%s  %zu bytes\n", path.c_str(), bytes.size());
  }
  return 0;
}
