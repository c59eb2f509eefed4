// The models by which a held part collides: made in parallel, kept on disk, dropped where a mesh changes.

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/field_cache.h"
#include "haptics/tick.h"
#include "tests/support/part_cases.h"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;
using haptics::ContactScene;
using haptics::ModelOptions;

/// A folder that goes with its test.
struct Folder {
  Folder() : path(fs::temp_directory_path() / ("tandem_models_" + std::to_string(getpid()))) {
    fs::remove_all(path);
  }
  ~Folder() {
    std::error_code error;
    fs::remove_all(path, error);
  }
  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    if (fs::exists(path))
      for (const auto& entry : fs::directory_iterator(path)) found.push_back(entry.path());
    return found;
  }
  fs::path path;
};

/// A cube of 10 mm that a hand can take, over a plate of 60 mm; all around the origin of their frames.
assets::Scene cubeOverPlate() {
  return sceneOfParts(
      {{"cube", meshOf(boxSoup(glm::dvec3(0.01))), Pose{{0.0, 0.0, 0.01}, {1.0, 0.0, 0.0, 0.0}}, true},
       {"plate", meshOf(moved(boxSoup(glm::dvec3(0.06)), {0.0, 0.0, -0.03}))}});
}

ModelOptions keptIn(const Folder& folder, int threads = 1) {
  ModelOptions options;
  options.cacheDirectory = folder.path.string();
  options.threads = threads;
  return options;
}

std::vector<std::vector<std::byte>> fieldsOf(const ContactScene& contact) {
  std::vector<std::vector<std::byte>> fields;
  for (const auto& model : contact.data().models) fields.push_back(model->field.pack());
  return fields;
}

std::size_t cachedOf(const ContactScene& contact) {
  std::size_t count = 0;
  for (const auto& model : contact.data().models) count += model->cached ? 1 : 0;
  return count;
}

TEST(PartModels, AreTheSameFromTheCache) {
  const Folder folder;
  const assets::Scene scene = cubeOverPlate();
  ContactScene fresh(scene, 1), second(scene, 1);
  ASSERT_TRUE(fresh.modelParts(keptIn(folder, 1)));
  EXPECT_EQ(folder.files().size(), 2u);
  EXPECT_EQ(cachedOf(fresh), 0u);
  ASSERT_TRUE(second.modelParts(keptIn(folder, 3)));
  EXPECT_EQ(cachedOf(second), 2u);
  EXPECT_EQ(fieldsOf(second), fieldsOf(fresh));
}

TEST(PartModels, AreMadeAnewWhereAFileIsDamagedCutShortOrOfSomethingElse) {
  const Folder folder;
  const assets::Scene scene = cubeOverPlate();
  ContactScene fresh(scene, 1);
  ASSERT_TRUE(fresh.modelParts(keptIn(folder)));
  const std::vector<fs::path> files = folder.files();
  ASSERT_EQ(files.size(), 2u);
  const auto spoil = [&](int how) {
    if (how == 0) fs::resize_file(files[0], fs::file_size(files[0]) - 5);
    if (how == 1) fs::copy_file(files[1], files[0], fs::copy_options::overwrite_existing);
    if (how == 2) fs::resize_file(files[0], 0);
    if (how < 3) return;
    // A number within a cell: all entries still lead somewhere, only the hash can tell.
    std::fstream file(files[0], std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(-4, std::ios::end);
    file.put('\x01');
  };
  for (int how = 0; how < 4; ++how) {
    spoil(how);
    ContactScene again(scene, 1), healed(scene, 1);
    ASSERT_TRUE(again.modelParts(keptIn(folder)));
    EXPECT_EQ(cachedOf(again), 1u) << how;
    EXPECT_EQ(fieldsOf(again), fieldsOf(fresh)) << how;
    ASSERT_TRUE(healed.modelParts(keptIn(folder)));
    EXPECT_EQ(cachedOf(healed), 2u) << "the file was written anew";
  }
  EXPECT_EQ(folder.files().size(), 2u) << "no temporary files are left";
}

TEST(PartModels, AreOnlyReadWhereAsked) {
  const Folder folder;
  const assets::Scene scene = cubeOverPlate();
  ModelOptions options = keptIn(folder);
  options.onlyCached = true;
  ContactScene none(scene, 1);
  ASSERT_TRUE(none.modelParts(options));
  EXPECT_TRUE(folder.files().empty());
  for (const auto& model : none.data().models) EXPECT_EQ(model, nullptr);
  ContactScene made(scene, 1), read(scene, 1);
  ASSERT_TRUE(made.modelParts(keptIn(folder)));
  ASSERT_TRUE(read.modelParts(options));
  EXPECT_EQ(cachedOf(read), 2u);
  EXPECT_EQ(fieldsOf(read), fieldsOf(made));
}

TEST(PartModels, AreMadeWhereTheCacheCannotBeWritten) {
  const Folder folder;
  std::ofstream(folder.path) << "a file where the folder should be";
  const assets::Scene scene = cubeOverPlate();
  ContactScene contact(scene, 1);
  EXPECT_TRUE(contact.modelParts(keptIn(folder)));
  EXPECT_EQ(contact.data().models.size(), 2u);
}

TEST(FieldCache, AnotherMeshOrToleranceIsAnotherField) {
  const Folder folder;
  assets::Mesh mesh = meshOf(boxSoup(glm::dvec3(0.01)));
  haptics::DistanceField::Options options;
  options.threads = 1;
  bool cached = true;
  const haptics::TriangleBvh tree(mesh, 1);
  static_cast<void>(haptics::cachedField(tree, options, folder.path.string(), cached));
  EXPECT_FALSE(cached);
  options.threads = 2;
  static_cast<void>(haptics::cachedField(tree, options, folder.path.string(), cached));
  EXPECT_TRUE(cached) << "threads make no difference";
  options.tolerance = 1e-5;
  static_cast<void>(haptics::cachedField(tree, options, folder.path.string(), cached));
  EXPECT_FALSE(cached);
  mesh.positions[0].x -= 1e-12;
  const haptics::TriangleBvh movedTree(mesh, 1);
  static_cast<void>(haptics::cachedField(movedTree, options, folder.path.string(), cached));
  EXPECT_FALSE(cached);
  EXPECT_EQ(folder.files().size(), 3u);
}

TEST(PartModels, TellHowFarTheyAreAndStopWhenAsked) {
  const assets::Scene scene = cubeOverPlate();
  ContactScene contact(scene, 1);
  ModelOptions options;
  options.threads = 1;
  std::vector<double> shares;
  options.progress = [&](double share, const char*) {
    shares.push_back(share);
    return shares.size() < 3;
  };
  EXPECT_FALSE(contact.modelParts(options));
  EXPECT_TRUE(contact.data().models.empty());
  shares.clear();
  options.progress = [&](double share, const char*) {
    shares.push_back(share);
    return true;
  };
  ASSERT_TRUE(contact.modelParts(options));
  ASSERT_GE(shares.size(), 3u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.front(), 0.0);
  EXPECT_NEAR(shares.back(), 1.0, 1e-12);
}

TEST(PartModels, AreNotMadeWhereNothingCanBeHeld) {
  assets::Scene scene = cubeOverPlate();
  scene.parts[0].movable = false;
  ContactScene contact(scene, 1);
  const std::size_t before = contact.memory();
  EXPECT_TRUE(contact.modelParts());
  EXPECT_TRUE(contact.data().models.empty());
  EXPECT_EQ(contact.memory(), before);
}

TEST(PartModels, CountInTheMemoryOfTheSceneAndOfTheirMesh) {
  const assets::Scene scene = cubeOverPlate();
  ContactScene contact(scene, 1);
  const std::size_t before = contact.memory(), meshBefore = contact.memory(0);
  ASSERT_TRUE(contact.modelParts());
  const auto& models = contact.data().models;
  EXPECT_GT(models[0]->memory(), models[0]->field.memory());
  EXPECT_EQ(contact.memory(0) - meshBefore, models[0]->memory());
  EXPECT_EQ(contact.memory() - before, models[0]->memory() + models[1]->memory());
}

/// Takes the cube and leads it 8 mm down, 3 mm deeper than it can go; where it ends, m, and the last flags.
struct Pressed {
  double height;
  std::uint32_t flags;
};
Pressed press(const ContactScene& contact, haptics::TickState& state) {
  haptics::TickParameters parameters;
  haptics::TickOutput out;
  for (int i = 0; i < 150; ++i) {
    haptics::TickInput input;
    const double z = 0.01 - 0.008 * std::min(1.0, i / 100.0);
    input.hands[0].device.worldFromDevice = Pose{{0.0, 0.0, z}, {1.0, 0.0, 0.0, 0.0}};
    input.hands[0].device.time = i * parameters.dt;
    input.hands[0].device.valid = true;
    const haptics::PartCommand take[2] = {
        {haptics::PartCommand::Kind::own, 0, Pose{{0.0, 0.0, 0.01}, {1.0, 0.0, 0.0, 0.0}}},
        {haptics::PartCommand::Kind::grasp, 0, {}}};
    if (i == 0) input.commands = take;
    out = haptics::tick(input, contact, parameters, state);
  }
  return {state.worldFromPart(0).position.z, out.flags};
}

TEST(PartModels, OfAMeshThatIsExchangedAreDroppedAndOthersStay) {
  const assets::Scene scene = cubeOverPlate();
  auto contact = std::make_unique<ContactScene>(scene, 1);
  ASSERT_TRUE(contact->modelParts());
  haptics::TickState before(*contact);
  const Pressed held = press(*contact, before);
  EXPECT_NEAR(held.height, 0.005, 2e-5) << "the cube rests on the plate";
  EXPECT_EQ(held.flags & haptics::kFlagHeldWithoutContact, 0u);

  ContactScene next = contact->withMesh(0, std::make_shared<assets::Mesh>(scene.meshes[0]), 1);
  contact.reset();  // what both share must live on
  EXPECT_EQ(next.data().models[0], nullptr);
  ASSERT_NE(next.data().models[1], nullptr);
  haptics::TickState state(next);
  const Pressed passed = press(next, state);
  EXPECT_LT(passed.height, 0.003);
  EXPECT_NE(passed.flags & haptics::kFlagHeldWithoutContact, 0u);
}

TEST(PartModels, OfAMeshThatIsRefittedAreDropped) {
  assets::Scene scene = cubeOverPlate();
  ContactScene contact(scene, 1);
  ASSERT_TRUE(contact.modelParts());
  haptics::TickState state(contact);
  const std::size_t with = contact.memory(1);
  contact.refitMesh(1, 1);
  state.meshesChanged(1);
  EXPECT_EQ(contact.data().models[1], nullptr);
  EXPECT_LT(contact.memory(1), with);
  const Pressed passed = press(contact, state);
  EXPECT_LT(passed.height, 0.003) << "the plate is no longer there for a held part";
}

}  // namespace
}  // namespace tandem::test
