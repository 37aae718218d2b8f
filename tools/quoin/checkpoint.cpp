#include "checkpoint.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>
#include <vector>

#include "hash.hpp"
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

/// Of the next `most` bytes, or of all there are.
std::uint64_t hash_of(std::istream& in, std::uint64_t hash, std::streamoff most) {
  std::vector<char> bytes(1 << 16);
  while (most > 0) {
    in.read(bytes.data(), std::min<std::streamoff>(std::ssize(bytes), most));
    if (in.gcount() == 0) break;
    most -= in.gcount();
    hash = hashed({bytes.data(), static_cast<std::size_t>(in.gcount())}, hash);
  }
  return hash;
}

std::uint64_t hash_of_file(const fs::path& path, std::uint64_t hash) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw FileError(path.string() + ": can't be read");
  return hash_of(in, hash, std::numeric_limits<std::streamoff>::max());
}

/// A checkpoint ends with the hash of what comes before.
void check_hash(std::istream& in) {
  std::uint64_t written = 0;
  in.seekg(0, std::ios::end);
  const std::streamoff size = in.tellg() - static_cast<std::streamoff>(sizeof written);
  in.seekg(0);
  const std::uint64_t found = hash_of(in, kHashOfNothing, size);
  if (size < 0 || !in.read(reinterpret_cast<char*>(&written), sizeof written) || written != found)
    throw FileError("the checkpoint is damaged, or of another program");
  in.seekg(0);
}

}  // namespace

std::string hash_of_inputs(const scene_file::SceneFile& file) {
  std::uint64_t hash = kHashOfNothing;
  for (const std::string& source : file.sources) hash = hash_of_file(source, hash);
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
  out.flush();
  if (!out) throw scene_file::unwritable(part.string());
  const std::uint64_t hash = hash_of_file(part, kHashOfNothing);
  out.write(reinterpret_cast<const char*>(&hash), sizeof hash);
  out.close();
  if (!out) throw scene_file::unwritable(part.string());
  sync(part);
  if (std::rename(part.c_str(), path.c_str()) != 0) throw scene_file::unwritable(path.string());
}

RunRequest read_request(std::istream& in) {
  std::string program;
  RunRequest request;
  check_hash(in);
  scene_file::ArchiveReader archive(in);
  archive(program);
  if (program != kProgram) throw FileError("the checkpoint is of another program");
  archive(request.scene, request.path, request.changes, request.on_failure,
          request.checkpoint_seconds, request.dump_steps, request.inputs);
  return request;
}

}  // namespace quoin::commands
