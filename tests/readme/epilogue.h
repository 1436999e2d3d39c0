int main() {
  readme_example();
  if (grasped == 0) std::puts("the example grasped nothing, but there is a rod to be held");
  return grasped > 0 && failed == 0 ? 0 : 1;
}
