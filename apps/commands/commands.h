// The commands of burin. Each Add...Command() adds one command to the program, with its
// options, help and a callback that does the work once the command line has been parsed.
// Results go to standard output and files, errors are thrown (apps/commands/command_line.h turns them into a
// line).
#pragma once

#include <string>

namespace burin {

class Program;

// burin synth --output DIR [--scene NAME] [--mesh scan.obj]: a scene with exact truth as a COLMAP
// workspace, with init.ply, truth.ply, truth_points.ply, depth/ and true_cameras/ beside it.
void AddSynthCommand(Program* program);

// burin evaluate --mesh M.ply --truth T.ply: the scores of a mesh, as text or as JSON; --scene SCENE --cameras
// TRUE_MODEL: errors of cameras.
void AddEvaluateCommand(Program* program);

// burin picture SCENE_DIR --mesh M.ply --truth T.ply --output FILE: the mesh, shaded and in the
// colours of its errors, from one view.
void AddPictureCommand(Program* program);

// burin check SCENE_DIR --mesh M.ply [--output DIR]: whether cameras, photographs and mesh fit each other.
void AddCheckCommand(Program* program);

// burin refine SCENE_DIR --mesh M.ply --output DIR: refined.ply, summary.json and trace.csv.
void AddRefineCommand(Program* program);

// burin mesh SCENE_DIR --output init.ply: a mesh to start from, made of the scene itself.
void AddMeshCommand(Program* program);

// burin select SCENE_DIR --mesh M.ply --output DIR: camera pairs with the reasons for them, as
// pairs.json, pair_terms.csv and pictures.
void AddSelectCommand(Program* program);

// burin demo [--output DIR]: makes the embedded scene, refines it, scores it against its truth and
// draws before and after.
void AddDemoCommand(Program* program);

// burin compare-solvers SCENE_DIR --mesh M.ply [--truth T.ply] --output DIR: every strategy from the same
// start; compare.csv, compare.json.
void AddCompareCommand(Program* program);

// burin convert SCENE OUTPUT: as a COLMAP workspace or NAME.mvs.
void AddConvertCommand(Program* program);

// burin solvers: the strategies by name, a line each.
void AddSolversCommand(Program* program);

// burin options [--markdown]: every option of every command, with default and permitted values.
void AddOptionsCommand(Program* program);

// What `burin options --markdown` prints and docs/options.md holds.
std::string OptionsDocument();

}  // namespace burin
