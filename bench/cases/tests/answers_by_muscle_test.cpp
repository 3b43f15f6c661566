// Contacts and errors of a replay, by muscle and bone.
#include "bench/cases/answers_by_muscle.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/tests/bar_and_ball.hpp"

namespace musclebench {
namespace {

using namespace bar_and_ball;

class AnswersOfTwo : public testing::Test {
 protected:
  [[nodiscard]] ReplayRecord prepared() const {
    ReplayRecord record;
    m_answers.prepare(record);
    return record;
  }
  [[nodiscard]] static Contact contact(int bone, int node) { return {node, bone, 1e-3, {0, 0, 1}}; }

  const Scene m_scene = read_scene(request(both()));
  const BackendEntry& m_backend = find_backend("bvh");
  const Case m_case{m_scene, m_backend, Parameters(m_backend.parameters, {}, "test")};
  const AnswersByMuscle m_answers{m_case};
  const int m_of_ball = m_scene.muscles[1].body.first_node;
};

TEST_F(AnswersOfTwo, CountContactsOfEachMuscleAndBone) {
  ReplayRecord record = prepared();
  m_answers.add_contacts(std::vector<Contact>{contact(0, 0), contact(0, m_of_ball), contact(1, m_of_ball)}, record);
  m_answers.add_contacts(std::vector<Contact>{contact(1, m_of_ball - 1), contact(1, m_of_ball)}, record);
  ASSERT_EQ(record.pairs.size(), 4U);
  EXPECT_EQ(record.pairs[bar_on_plate].contacts, 1);
  EXPECT_EQ(record.pairs[ball_on_plate].contacts, 1);
  EXPECT_EQ(record.pairs[bar_at_lid].contacts, 1);
  EXPECT_EQ(record.pairs[ball_at_lid].contacts, 2);
  ASSERT_EQ(record.muscles.size(), 2U);
  EXPECT_EQ(record.muscles[0].contacts, 2);
  EXPECT_EQ(record.muscles[1].contacts, 3);
  EXPECT_EQ(record.pairs[bar_at_lid].muscle, m_scene.muscles[0].body.name);
  EXPECT_EQ(record.pairs[bar_at_lid].other, m_scene.bones[1].name);
}

TEST_F(AnswersOfTwo, SumTimesOfStepsAndLeaveThemOutWhereTheyAreNotTold) {
  ReplayRecord record = prepared();
  AnswersByMuscle::add_times({}, record);
  EXPECT_FALSE(record.pairs[bar_on_plate].detect_ns);
  AnswersByMuscle::add_times(std::vector<Nanoseconds>{1, 2, 3, 4}, record);
  AnswersByMuscle::add_times(std::vector<Nanoseconds>{0, 20, 0, 40}, record);
  EXPECT_EQ(record.pairs[bar_on_plate].detect_ns, 1);
  EXPECT_EQ(record.pairs[ball_on_plate].detect_ns, 22);
  EXPECT_EQ(record.pairs[ball_at_lid].detect_ns, 44);
}

TEST_F(AnswersOfTwo, TellWhoseContactWasMissed) {
  Referee referee(m_scene.bones, static_cast<int>(m_scene.muscle_mesh.vertices.size()));
  const std::vector<RigidMotion> poses(m_scene.bones.size());
  const std::vector<Contact> truth{contact(0, 0), contact(0, m_of_ball), contact(1, 1)};
  std::vector<Contact> answered = truth;
  answered.erase(answered.begin() + 1);
  std::vector<AnswerErrors> errors(m_answers.parts());
  m_answers.measure(referee, {poses, m_scene.muscle_mesh.vertices, answered}, truth, 1, errors);
  ReplayRecord record = prepared();
  m_answers.add_accuracy(errors, record);
  EXPECT_EQ(record.pairs[ball_on_plate].accuracy->missed_contacts, 1);
  EXPECT_EQ(record.pairs[bar_on_plate].accuracy->missed_contacts, 0);
  EXPECT_EQ(record.pairs[bar_at_lid].accuracy->true_contacts, 1);
  EXPECT_EQ(record.muscles[1].accuracy->missed_contacts, 1);
  EXPECT_EQ(record.muscles[0].accuracy->true_contacts, 2);
  EXPECT_EQ(record.accuracy->missed_contacts, 1);
  EXPECT_EQ(record.accuracy->true_contacts, 3);
}

TEST(AnswersByMuscle, AreNotToldApartWhereThereIsButOne) {
  Scene scene = read_scene(bar_and_ball::request(bar_and_ball::both()));
  const Body ball = scene.muscles[1].body;
  scene.muscles.erase(scene.muscles.begin());
  const BackendEntry& backend = find_backend("bvh");
  const Case resolved{scene, backend, Parameters(backend.parameters, {}, "test")};
  const AnswersByMuscle answers(resolved);
  ReplayRecord record;
  answers.prepare(record);
  answers.add_contacts(std::vector<Contact>{{ball.first_node, 0, 0, {0, 0, 0}}}, record);
  EXPECT_TRUE(record.pairs.empty());
  EXPECT_TRUE(record.muscles.empty());
  EXPECT_EQ(answers.parts(), 1U);
}

}  // namespace
}  // namespace musclebench
