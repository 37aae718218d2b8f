#include "checkpoint.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "scene_file/archive.hpp"

namespace quoin::commands {
namespace {

namespace fs = std::filesystem;
using scene_file::FileError;

const std::string kProgram = "quoin " QUOIN_VERSION " checkpoint, " __VERSION__;

/// To the disk, not only to its cache: a checkpoint outlives a power cut.
void sync(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

}  // namespace

std::string hash_of_inputs(const scene_file::SceneFile& file) {
  std::uint64_t hash = 14695981039346656037U;
  for (const std::string& source : file.sources) {
    std::ifstream in(source, std::ios::binary);
    if (!in) throw FileError(source + ": can't be read");
    std::vector<char> bytes(1 << 16);
    while (in.read(bytes.data(), std::ssize(bytes)) || in.gcount() > 0) {
      for (std::streamsize i = 0; i < in.gcount(); ++i) {
        const auto byte = static_cast<unsigned char>(bytes[static_cast<std::size_t>(i)]);
        hash = (hash ^ byte) * 1099511628211U;  // FNV-1a
      }
    }
  }
  return std::to_string(hash);
}

void write_checkpoint(OutputFolder& folder, const RunRequest& request, RunFiles& files,
                      const scene_file::SaveRun& save) {
  const fs::path path = folder.file(OutputFolder::kCheckpoint);
  fs::path part = path;
  part += ".part";
  std::ofstream out(part, std::ios::binary);
  scene_file::ArchiveWriter archive(out);
  archive(kProgram, request.scene, request.path, request.changes, request.on_failure,
          request.checkpoint_seconds, request.dump_steps, request.inputs);
  files.save(out);
  save(out);
  out.close();
  if (!out) throw scene_file::unwritable(part.string());
  sync(part);
  if (std::rename(part.c_str(), path.c_str()) != 0) {
    throw scene_file::unwritable(path.string());
  }
}

RunRequest read_request(std::istream& in) {
  std::string program;
  RunRequest request;
  scene_file::ArchiveReader archive(in);
  archive(program);
  if (program != kProgram) throw FileError("the checkpoint is of another program");
  archive(request.scene, request.path, request.changes, request.on_failure,
          request.checkpoint_seconds, request.dump_steps, request.inputs);
  return request;
}

}  // namespace quoin::commands
