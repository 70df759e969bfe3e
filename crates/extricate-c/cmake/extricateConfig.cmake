# Defines extricate::extricate, the shared library, and extricate::static, the static one. A target is missing if its
# library was not installed. C++ that links one of them is compiled as C++17 at least, which extricate.hpp needs.
#
# This file is in PREFIX/share/cmake/extricate. The libraries are in PREFIX/lib, in PREFIX/lib64, or in a folder of
# PREFIX/lib that is named after the machine. They are where extricate.pc is.
cmake_minimum_required(VERSION 3.16)

if(TARGET extricate::extricate OR TARGET extricate::static)
    return()
endif()

get_filename_component(_extricate_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
set(_extricate_folders lib)
if(CMAKE_SIZEOF_VOID_P EQUAL 8)
    list(PREPEND _extricate_folders lib64)
endif()
if(CMAKE_LIBRARY_ARCHITECTURE)
    list(PREPEND _extricate_folders "lib/${CMAKE_LIBRARY_ARCHITECTURE}")
endif()
unset(_extricate_libdir)
foreach(_extricate_folder IN LISTS _extricate_folders)
    if(EXISTS "${_extricate_prefix}/${_extricate_folder}/pkgconfig/extricate.pc")
        set(_extricate_libdir "${_extricate_prefix}/${_extricate_folder}")
        break()
    endif()
endforeach()
if(NOT _extricate_libdir)
    list(JOIN _extricate_folders ", " _extricate_folders)
    set(extricate_FOUND FALSE)
    set(extricate_NOT_FOUND_MESSAGE
        "no pkgconfig/extricate.pc in ${_extricate_prefix}, expected it in one of ${_extricate_folders}")
    return()
endif()

# CMake 3.18 refuses features of C++ in a project of C alone.
set(_extricate_features)
get_property(_extricate_languages GLOBAL PROPERTY ENABLED_LANGUAGES)
if("CXX" IN_LIST _extricate_languages)
    set(_extricate_features cxx_std_17)
endif()

if(WIN32)
    set(_extricate_shared "${_extricate_prefix}/bin/extricate_c.dll")
    if(MSVC)
        set(_extricate_import "${_extricate_libdir}/extricate_c.dll.lib")
    else()
        set(_extricate_import "${_extricate_libdir}/extricate_c.dll.a")
    endif()
else()
    set(_extricate_shared "${_extricate_libdir}/libextricate_c${CMAKE_SHARED_LIBRARY_SUFFIX}")
endif()
if(EXISTS "${_extricate_shared}")
    add_library(extricate::extricate SHARED IMPORTED)
    set_target_properties(extricate::extricate PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${_extricate_prefix}/include"
        INTERFACE_COMPILE_FEATURES "${_extricate_features}"
        IMPORTED_LOCATION "${_extricate_shared}")
    if(WIN32)
        set_target_properties(extricate::extricate PROPERTIES IMPORTED_IMPLIB "${_extricate_import}")
    endif()
endif()

set(_extricate_static
    "${_extricate_libdir}/${CMAKE_STATIC_LIBRARY_PREFIX}extricate_c${CMAKE_STATIC_LIBRARY_SUFFIX}")
if(EXISTS "${_extricate_static}")
    # cargo-c writes the system's libraries into extricate.pc, as the compiler named them for this platform.
    file(STRINGS "${_extricate_libdir}/pkgconfig/extricate.pc" _extricate_system REGEX "^Libs\\.private:")
    string(REGEX REPLACE "^Libs\\.private:" "" _extricate_system "${_extricate_system}")
    separate_arguments(_extricate_system UNIX_COMMAND "${_extricate_system}")
    if(MSVC)
        list(TRANSFORM _extricate_system REPLACE "^-l(.*)$" "\\1.lib")
    endif()
    add_library(extricate::static STATIC IMPORTED)
    set_target_properties(extricate::static PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${_extricate_prefix}/include"
        INTERFACE_COMPILE_FEATURES "${_extricate_features}"
        INTERFACE_LINK_LIBRARIES "${_extricate_system}"
        IMPORTED_LOCATION "${_extricate_static}")
endif()
