// Prints what libsdformat reads in a model: bodies where they are in zero position, then joints.
#include <iomanip>
#include <iostream>
#include <sdf/sdf.hh>

std::ostream &print(const ignition::math::Vector3d &v) {  // its own operator rounds
  return std::cout << ' ' << v.X() << ' ' << v.Y() << ' ' << v.Z();
}

int main(int, char **argv) {
  sdf::Root root;
  const auto errors = root.Load(argv[1]);
  for (const auto &error : errors) std::cerr << error.Message() << std::endl;
  if (!errors.empty() || !root.Model()) return 1;
  std::cout << std::setprecision(17);
  const auto *model = root.Model();
  for (uint64_t i = 0; i < model->LinkCount(); ++i) {
    const auto *link = model->LinkByIndex(i);
    ignition::math::Pose3d pose;
    if (!link->SemanticPose().Resolve(pose, "__model__").empty()) return 1;
    const auto center = (pose * link->Inertial().Pose()).Pos();
    const auto moments = link->Inertial().Moi();
    std::cout << "link " << link->Name() << ' ' << link->Inertial().MassMatrix().Mass();
    print(center);
    const ignition::math::Matrix3d rotation(pose.Rot());
    const auto turned = rotation * moments * rotation.Transposed();
    for (int row = 0; row < 3; ++row)
      for (int column = row; column < 3; ++column) std::cout << ' ' << turned(row, column);
    std::cout << '\n';
  }
  for (uint64_t i = 0; i < model->JointCount(); ++i) {
    const auto *joint = model->JointByIndex(i);
    const auto *axis = joint->Axis(0);
    if (!axis) continue;  // it is fixed
    ignition::math::Vector3d direction;
    if (!axis->ResolveXyz(direction, "__model__").empty()) return 1;
    std::cout << "joint " << joint->Name();
    print(direction) << ' ' << axis->Lower() << ' ' << axis->Upper()
              << ' ' << axis->Effort() << ' ' << axis->MaxVelocity() << ' ' << axis->Damping() << ' '
              << axis->Friction() << ' ' << axis->SpringReference() << ' ' << axis->SpringStiffness() << '\n';
  }
}
