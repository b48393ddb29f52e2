"""Plans: trajectories with their robot, limits and criteria, as files, pages, views and exports."""
