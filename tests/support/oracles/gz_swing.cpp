// Free swing of an SDF model in gz-physics: model.sdf, then joint, position and velocity on stdin.
#include <chrono>
#include <iomanip>
#include <iostream>
#include <string>
#include <vector>

#include <ignition/physics/ForwardStep.hh>
#include <ignition/physics/GetEntities.hh>
#include <ignition/physics/Joint.hh>
#include <ignition/physics/RequestEngine.hh>
#include <ignition/physics/sdf/ConstructModel.hh>
#include <ignition/physics/sdf/ConstructWorld.hh>
#include <ignition/plugin/Loader.hh>
#include <sdf/Root.hh>
#include <sdf/World.hh>

namespace physics = ignition::physics;

using Features = physics::FeatureList<
    physics::sdf::ConstructSdfWorld, physics::sdf::ConstructSdfModel, physics::ForwardStep,
    physics::GetJointFromModel, physics::GetBasicJointState, physics::SetBasicJointState>;

int main(int count, char **words)
{
    if (count != 5) return 2;  // library, model, gravity along z, steps
    ignition::plugin::Loader loader;
    loader.LoadLib(words[1]);
    auto plugin = loader.Instantiate("ignition::physics::dartsim::Plugin");
    auto engine = physics::RequestEngine3d<Features>::From(plugin);
    sdf::Root root;
    for (const auto &error : root.Load(words[2])) std::cerr << error << "\n";
    if (!engine || !root.Model()) return 3;
    sdf::World space;
    space.SetName("world");
    space.SetGravity({0.0, 0.0, std::stod(words[3])});
    auto world = engine->ConstructWorld(space);
    auto model = world->ConstructModel(*root.Model());
    if (!model) return 4;
    std::vector<physics::Joint3dPtr<Features>> joints;
    std::vector<std::size_t> places;
    std::string name;
    std::size_t place;
    double q, qd;
    while (std::cin >> name >> place >> q >> qd) {
        auto joint = model->GetJoint(name);
        if (!joint) return 5;
        joint->SetPosition(place, q);
        joint->SetVelocity(place, qd);
        joints.push_back(joint);
        places.push_back(place);
    }
    physics::ForwardStep::Input input;
    physics::ForwardStep::State state;
    physics::ForwardStep::Output output;
    input.Get<std::chrono::steady_clock::duration>() = std::chrono::milliseconds(1);
    for (long k = std::stol(words[4]); k > 0; --k) world->Step(output, state, input);
    std::cout << std::setprecision(17);
    for (std::size_t k = 0; k < joints.size(); ++k)
        std::cout << joints[k]->GetPosition(places[k]) << "\n";
}
