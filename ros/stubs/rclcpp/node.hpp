#pragma once
#include <moveit/stub.hpp>
