#pragma once
#include <moveit_stub.hpp>
