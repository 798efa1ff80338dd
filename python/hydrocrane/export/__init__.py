"""What other people's tools take: machines and controllers as FMUs."""
